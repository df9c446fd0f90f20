// SPDX-License-Identifier: Apache-2.0
#include "pipeline/base/options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/base/error.h"

namespace nightmap::options_test {

struct Tree {
  int depth = 2;
  double unregistered = 0;
};

struct Options {
  OPTION(bool, flag, true, "a flag");
  OPTION(int, count, 3, {1, 10}, "a count");
  OPTION(double, size_m, 0.5, {0, 1}, "a size");
  OPTION(std::string, kind, "sift", {"sift", "orb"}, "a choice");
  OPTION(std::vector<int>, offsets, std::vector<int>({1, 2}), {1, 9}, "a list");
  REGISTER_OPTIONS();
};

std::string MessageOf(const std::string& toml) {
  Options options;
  try {
    RegisterOptions(options).ParseToml(toml, "x.toml");
  } catch (const UsageError& error) {
    EXPECT_EQ(error.Code(), ExitCode::kUsageError);
    return error.what();
  }
  return "";
}

TEST(Options, DeeplyNestedListsAreRefused) {
  const std::string deep = std::string(100'000, '[') + std::string(100'000, ']');
  EXPECT_THAT(MessageOf("offsets = " + deep + "\n"),
              testing::HasSubstr("x.toml:1: not valid TOML"));
  const std::string tables = std::string(100'000, '{');
  EXPECT_THAT(MessageOf("offsets = " + tables), testing::HasSubstr("x.toml:1: not valid TOML"));
}

TEST(Options, ParsesEveryType) {
  Options options;
  RegisterOptions(options).ParseToml(
      "flag = false\ncount = 7\nsize_m = 1\nkind = \"orb\"\noffsets = [4, 5]\n", "x.toml");
  EXPECT_FALSE(options.flag);
  EXPECT_EQ(options.count, 7);
  EXPECT_EQ(options.size_m, 1.0);
  EXPECT_EQ(options.kind, "orb");
  EXPECT_THAT(options.offsets, testing::ElementsAre(4, 5));
}

struct StageOptions {
  OPTION(int, own, 1, {0, 9}, "an option of the stage");
  OPTIONS_OF(Options, shared, "shared_");
  Tree tree;
  OPTION_AT("tree_depth", tree.depth, {1, 8}, "a parameter of a library");
  Options same{.count = 7};
  OPTIONS_AT(same);
  REGISTER_OPTIONS();
};

TEST(Options, ComeInTheOrderOfTheFieldsWithThoseOfSharedStructsAndLibraries) {
  StageOptions options;
  EXPECT_EQ(RegisterOptions(options).ToToml(),
            "own = 1\n"
            "shared_flag = true\nshared_count = 3\nshared_size_m = 0.5\nshared_kind = \"sift\"\n"
            "shared_offsets = [1, 2]\n"
            "tree_depth = 2\n"
            "flag = true\ncount = 7\nsize_m = 0.5\nkind = \"sift\"\noffsets = [1, 2]\n");
  RegisterOptions(options).ParseToml("shared_count = 4\ntree_depth = 5\n", "x.toml");
  EXPECT_EQ(options.shared.count, 4);
  EXPECT_EQ(options.same.count, 7);
  EXPECT_EQ(options.tree.depth, 5);
}

TEST(Options, CommentsSayTheMeaningAndTheRange) {
  Options options;
  OptionList list = RegisterOptions(options);
  EXPECT_THAT(list.ToCommentedToml(), testing::HasSubstr("\n# a size; 0 .. 1\nsize_m = 0.5\n"));
  EXPECT_THAT(list.ToCommentedToml(), testing::HasSubstr("\n# a flag\nflag = true\n"));
  int number = 0;
  list.Add("number", &number, std::string(60, 'a') + " " + std::string(60, 'b'));
  EXPECT_THAT(list.ToCommentedToml(),
              testing::HasSubstr("\n# " + std::string(60, 'a') + "\n# " + std::string(60, 'b') +
                                 "\nnumber = 0\n"));
  list.ParseToml(list.ToCommentedToml(), "x.toml");
}

TEST(Options, PrintingIsAFixedPoint) {
  Options first;
  first.size_m = 1.0 / 3;
  const std::string text = RegisterOptions(first).ToToml();
  Options second;
  OptionList list = RegisterOptions(second);
  list.ParseToml(text, "x.toml");
  EXPECT_EQ(list.ToToml(), text);
  EXPECT_EQ(second.size_m, first.size_m);
}

TEST(Options, RefusesWithFileAndLine) {
  using testing::HasSubstr;
  EXPECT_THAT(MessageOf("count = 2\nspeed = 1\n"), HasSubstr("x.toml:2: unknown key 'speed'"));
  EXPECT_THAT(MessageOf("\ncount = 11\n"), HasSubstr("x.toml:2: count = 11 is out of range"));
  EXPECT_THAT(MessageOf("count = 2.5\n"), HasSubstr("must be an integer"));
  EXPECT_THAT(MessageOf("size_m = nan\n"), HasSubstr("out of range"));
  EXPECT_THAT(MessageOf("kind = \"surf\"\n"), HasSubstr("one of sift, orb"));
  EXPECT_THAT(MessageOf("offsets = [1, 10]\n"), HasSubstr("out of range"));
  EXPECT_THAT(MessageOf("count = \n"), HasSubstr("x.toml:1: not valid TOML"));
}

TEST(Options, HelpNamesEveryOptionWithDefaultAndRange) {
  Options options;
  const std::string help = RegisterOptions(options).Help();
  EXPECT_THAT(help, testing::HasSubstr("size_m   a size [default 0.5; 0 .. 1]"));
  EXPECT_THAT(help, testing::HasSubstr("kind     a choice [default \"sift\"; one of sift, orb]"));
}

}  // namespace nightmap::options_test
