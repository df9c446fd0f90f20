// SPDX-License-Identifier: Apache-2.0
// Shared frame of every stage program: command line, config, exit codes of errors, atomic outputs,
// report and receipt. A stage's main.cc is one call of StageMain.
//
// Paths are checked before anything is read or written. An output must be the path of a plain file
// or a new path, and neither an input nor another output. A symbolic link in the place of an output
// is replaced; its target stays untouched.
//
// --in-list NAME=FILE stands for --in NAME=PATH with each line of FILE in turn, after the paths
// that --in gives to NAME. The receipt lists the inputs, but not the list.
//
//   <stage> --config FILE --in NAME=PATH ... --in-list NAME=FILE ... --out NAME=PATH ...
//           [--threads N] [--log-level L]
//   <stage> --help | --version | --print-config [--config FILE] | --print-ports
//   <stage> --check-config --config FILE [--in site=FILE]
#pragma once

#include <functional>
#include <utility>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/base/options.h"
#include "pipeline/program/stage_context.h"

// A stage's main.cc is part of its library. Tests, which link that too, have a main of their own.
int main(int argc, char** argv);
#pragma weak main

namespace nightmap {

int RunStage(int argc,
             char** argv,
             const StageSpec& spec,
             OptionList options,
             const std::function<void(StageContext&)>& body);

// Calls body(options, context). Returns the exit code of the program.
template <typename Options, typename Body>
int StageMain(int argc, char** argv, const StageSpec& spec, Options options, Body body) {
  return RunStage(argc, argv, spec, RegisterOptions(options), [&](StageContext& context) {
    body(std::as_const(options), context);
  });
}

}  // namespace nightmap
