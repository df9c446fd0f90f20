// SPDX-License-Identifier: Apache-2.0
// What every stage program shares: command line, config, errors to exit codes, atomic outputs,
// report and receipt. A stage's main.cc is one call of StageMain.
//
// A mistake in the call is found before anything is read or written: an output must be the path of
// a plain file, or of nothing yet, and neither an input nor another output. A symbolic link in the
// place of an output is replaced; the file that it points at stays as it is.
//
// --in-list NAME=FILE stands for --in NAME=PATH with each line of FILE in turn, after the paths
// that
// --in gives to NAME. The inputs are in the receipt; the list is not.
//
//   <stage> --config FILE --in NAME=PATH ... --in-list NAME=FILE ... --out NAME=PATH ...
//           [--threads N] [--log-level L]
//   <stage> --help | --version | --print-config [--config FILE] | --check-config --config FILE
#pragma once

#include <functional>
#include <utility>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/base/options.h"
#include "pipeline/program/stage_context.h"

namespace nightmap {

int RunStage(int argc,
             char** argv,
             const StageSpec& spec,
             OptionList options,
             const std::function<void(StageContext&)>& body);

// body(options, context). Returns the exit code of the program.
template <typename Options, typename Body>
int StageMain(int argc, char** argv, const StageSpec& spec, Options options, Body body) {
  return RunStage(argc, argv, spec, RegisterOptions(options), [&](StageContext& context) {
    body(std::as_const(options), context);
  });
}

}  // namespace nightmap
