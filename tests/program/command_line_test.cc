// SPDX-License-Identifier: Apache-2.0
#include "pipeline/program/command_line.h"

#include "tests/test_data.h"

namespace nightmap::command_line_test {

TEST(PortLines, HaveKindAndNumberOfPaths) {
  const StageSpec spec{"copy",
                       "copies",
                       {{"in", "a file"},
                        FolderPort("data", "a folder", Arity::kOptional),
                        {"masks", "some files", Arity::kMany, PortKind::kByHash},
                        {"more", "files", Arity::kAnyNumber}},
                       {{"out", "a file"}}};
  EXPECT_EQ(PortLines(spec),
            "in in file one\nin data folder optional\nin masks by_hash many\n"
            "in more file any_number\nout out file one\n");
}

}  // namespace nightmap::command_line_test
