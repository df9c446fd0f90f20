// SPDX-License-Identifier: Apache-2.0
#include "pipeline/program/stage_main.h"

#include <sys/stat.h>

#include <cerrno>
#include <chrono>
#include <map>
#include <system_error>
#include <thread>

#include "pipeline/base/input_error.h"
#include "pipeline/base/memory.h"
#include "pipeline/program/run_cost.h"
#include "tests/test_data.h"

namespace nightmap::stage_main_test {

struct Options {
  int size = 3;
  void Register(OptionList& list) { list.Add("size", &size, Range(1, 10), "how large"); }
};

using Body = std::function<void(const Options&, StageContext&)>;

struct Result {
  int code = -1;
  std::string out, err;
};

class StageMainTest : public testing::Test {
 protected:
  // Runs the stage of spec_.
  Result Main(std::vector<std::string> arguments, const Body& body = CopyBody) const {
    arguments.insert(arguments.begin(), "copy");
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    Result run;
    run.code = StageMain(static_cast<int>(argv.size()), argv.data(), spec_, Options{}, body);
    run.out = testing::internal::GetCapturedStdout();
    run.err = testing::internal::GetCapturedStderr();
    return run;
  }
  std::vector<std::string> Ports() const {
    std::vector<std::string> arguments{"--in", "in=" + (folder_ / "in.txt").string()};
    for (const char* name : {"out", "report", "receipt"}) {
      arguments.insert(arguments.end(), {"--out", name + ("=" + (folder_ / name).string())});
    }
    return arguments;
  }
  std::vector<std::string> With(const std::vector<std::string>& more) const {
    std::vector<std::string> arguments = Ports();
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  static void Never(const Options&, StageContext&) { ADD_FAILURE() << "the body runs"; }
  static void CopyBody(const Options& options, StageContext& context) {
    context.Report()["size"] = options.size;
    context.Skip("one bad item");
    WriteFile(context.Output("out"), ReadFile(context.Input("in")));
  }
  static void JoinBody(const Options&, StageContext& context) {
    EXPECT_FALSE(context.HasInput("extra"));
    std::string all;
    for (const auto& path : context.Inputs("in")) all += ReadFile(path);
    WriteFile(context.Output("out"), all);
  }
  // CopyBody, and then this.
  template <typename More>
  static Body CopyAnd(const More& more) {
    return [more](const Options& options, StageContext& context) {
      CopyBody(options, context);
      more(context);
    };
  }
  nlohmann::json Json(const char* name) const {
    return nlohmann::json::parse(ReadFile(folder_ / name));
  }
  // The run ends with this code, says this, and writes nothing.
  void ExpectFailure(const std::vector<std::string>& arguments,
                     int code,
                     const std::string& message,
                     const Body& body = CopyBody) const {
    SCOPED_TRACE(message);
    const Result run = Main(arguments, body);
    EXPECT_EQ(run.code, code);
    EXPECT_THAT(run.err, testing::HasSubstr(message));
    ExpectNothingWritten();
    EXPECT_TRUE(!std::filesystem::exists(input_) || ReadFile(input_) == "hello");
  }
  void ExpectNothingWritten() const {
    for (const char* name : {"out", "report", "receipt"}) {
      EXPECT_FALSE(std::filesystem::exists(folder_ / name)) << name;
    }
  }

  StageSpec spec_{"copy", "copies a file", {{"in", "a file"}}, {{"out", "its copy"}}};
  TemporaryFolder folder_;
  std::filesystem::path input_ = folder_.Write("in.txt", "hello");
};

TEST_F(StageMainTest, ReceiptHasTheTimesOfEachPart) {
  const auto body = [](const Options& options, StageContext& context) {
    context.BeginPart("work");
    const double start_s = CpuTime_s();
    while (CpuTime_s() < start_s + 0.05) {
    }
    context.BeginPart("wait");
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    context.BeginPart("work");
    CopyBody(options, context);
  };
  ASSERT_EQ(Main(Ports(), body).code, 0);
  const auto receipt = Json("receipt");
  std::map<std::string, nlohmann::json> parts;
  double sum_s = 0;
  for (const auto& part : receipt["parts"]) {
    parts[part["name"]] = part;
    sum_s += part["cpu_time_s"].get<double>();
  }
  EXPECT_GE(parts["work"]["cpu_time_s"], 0.05);
  EXPECT_LT(parts["wait"]["cpu_time_s"], 0.05);
  EXPECT_GE(parts["wait"]["wall_time_s"], 0.05);
  EXPECT_LE(sum_s, receipt["cpu_time_s"].get<double>());
}

TEST_F(StageMainTest, MessagesObeyNoControlInAUsersText) {
  ExpectFailure(
      Ports(), 1, "a\\x1b[31m\\x07: no such name\nremedy\n", [](const Options&, StageContext&) {
        throw DataError("{}: no such name\nremedy", "a\x1b[31m\a");
      });
  const Result run = Main({"--in", "a\x1b[31m"});
  EXPECT_EQ(run.err.find('\x1b'), std::string::npos) << run.err;
}

TEST_F(StageMainTest, HelpNamesEveryPortAndOptionWithRangeAndDefault) {
  const Result run = Main({"--help"});
  EXPECT_EQ(run.code, 0);
  using testing::HasSubstr;
  EXPECT_THAT(run.out, AllOf(HasSubstr("copies a file"), HasSubstr("its copy")));
  EXPECT_THAT(run.out, AllOf(HasSubstr("size"), HasSubstr("how large"), HasSubstr("10")));
  EXPECT_THAT(run.out, AllOf(HasSubstr("a file"), HasSubstr("3"), HasSubstr("--threads")));
  EXPECT_THAT(run.out, AllOf(HasSubstr("--in-list"), HasSubstr("--print-config")));
  EXPECT_THAT(run.out, AllOf(HasSubstr("report"), HasSubstr("receipt")));
}

TEST_F(StageMainTest, VersionAndConfigGoToStdout) {
  EXPECT_THAT(Main({"--version"}).out, testing::HasSubstr("nightmap"));
  const Result run = Main({"--print-config"});
  EXPECT_EQ(run.code, 0);
  EXPECT_THAT(run.out, testing::HasSubstr("size = 3"));
  const auto config = folder_.Write("copy.toml", run.out);
  EXPECT_EQ(Main({"--check-config", "--config", config.string()}).code, 0);
  folder_.Write("copy.toml", "size = 7\n");
  EXPECT_THAT(Main({"--print-config", "--config", config.string()}).out,
              testing::EndsWith("\nsize = 7\n"));
}

TEST_F(StageMainTest, WritesOutputsReportAndReceipt) {
  const auto config = folder_.Write("copy.toml", "size = 7\n");
  const Result run = Main(With({"--config", config.string()}));
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_EQ(run.out, "");
  EXPECT_EQ(ReadFile(folder_ / "out"), "hello");
  const auto report = Json("report");
  EXPECT_EQ(report["size"], 7);
  EXPECT_EQ(report["num_skipped"], 1);
  EXPECT_EQ(report["skipped"][0], "one bad item");
  EXPECT_EQ(report["config"], "size = 7\n");
  const auto receipt = Json("receipt");
  EXPECT_EQ(receipt["inputs"][0]["xxh3"], HashBytes("hello"));
  EXPECT_EQ(receipt["outputs"][0]["xxh3"], HashBytes("hello"));
  EXPECT_GT(receipt["peak_memory_bytes"], 0);
}

TEST_F(StageMainTest, ARunThatFailsMayLeaveOneFileAndTheNextRunRemovesIt) {
  spec_.failure_file = "why.txt";
  const auto fail = [](const Options&, StageContext& context) {
    WriteFile(context.Output("out"), "half");
    context.LeaveFailureFile([](const auto& path) { WriteFile(path, "this is why"); });
    throw DataError("no");
  };
  EXPECT_THAT(Main({"--help"}).out, testing::HasSubstr("why.txt"));
  const Result failed = Main(Ports(), fail);
  EXPECT_EQ(failed.code, 1);
  EXPECT_THAT(failed.err, testing::HasSubstr("why.txt shows more"));
  ExpectNothingWritten();
  EXPECT_EQ(ReadFile(folder_ / "why.txt"), "this is why");
  const auto fail_at_once = [](const Options&, StageContext&) { throw DataError("no"); };
  EXPECT_EQ(Main(Ports(), fail_at_once).code, 1);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "why.txt"));
  EXPECT_EQ(Main(Ports(), fail).code, 1);
  ASSERT_EQ(Main(Ports()).code, 0);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "why.txt"));
  const auto cannot_write = [](const Options&, StageContext& context) {
    context.LeaveFailureFile([](const auto&) { throw DataError("the disk is full"); });
    throw DataError("the reason");
  };
  const Result unwritten = Main(Ports(), cannot_write);
  EXPECT_EQ(unwritten.code, 1);
  EXPECT_THAT(unwritten.err, testing::HasSubstr("why.txt is not written: the disk is full"));
  EXPECT_THAT(unwritten.err, testing::HasSubstr("the reason"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "why.txt"));
  spec_.failure_file = "in.txt";  // never an input
  EXPECT_EQ(Main(Ports(), fail).code, 2);
  EXPECT_EQ(ReadFile(input_), "hello");
}

TEST_F(StageMainTest, FilesThatAnInputNamesAreInputs) {
  const auto named = folder_.Write("named.txt", "more");
  const Body body =
      CopyAnd([&](StageContext& context) { context.AddInput(named, context.Input("in")); });
  ASSERT_EQ(Main(Ports(), body).code, 0);
  const auto inputs = Json("receipt")["inputs"];
  ASSERT_EQ(inputs.size(), 2U);
  EXPECT_EQ(inputs[1]["name"], "named.txt");
  EXPECT_EQ(inputs[1]["xxh3"], HashBytes("more"));
  for (const char* name : {"out", "report", "receipt"}) std::filesystem::remove(folder_ / name);
  std::filesystem::remove(named);
  ExpectFailure(Ports(), 1, named.string() + ": " + input_.string() + " names", body);
}

TEST_F(StageMainTest, MistakesInTheCallAreUsageErrors) {
  const auto config = folder_.Write("bad.toml", "sise = 7\n");
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {With({"--config", config.string()}), "bad.toml:1"},
      {{"--config", (folder_ / "none.toml").string()}, "none.toml"},
      {With({"--in", "other=x"}), "other=x"},
      {With({"--out", "other=x"}), "other=x"},
      {With({"--in", "in.txt"}), "NAME=PATH"},
      {With({"--in", "in=" + input_.string()}), "given 2 times"},
      {{"--in", "in=" + input_.string()}, "out=PATH is missing"},
      {With({"--threads", "-1"}), "threads"},
      {With({"--no-such-flag"}), "no-such-flag"},
      {{"--check-config", "--config", config.string()}, "sise"}};
  for (const auto& [arguments, message] : cases) ExpectFailure(arguments, 2, message);
}

TEST_F(StageMainTest, ACheckedInputMayReferToAnother) {
  std::string read;
  spec_.inputs = {
      CheckedPort("base", "names", [&](const auto& file) { read += "base " + ReadFile(file); }),
      CheckedPort("user", "uses them", "base", [&](const auto& file, const auto& base) {
        read += "; " + ReadFile(file) + " of " + ReadFile(base);
      })};
  const std::string base = "base=" + folder_.Write("base.txt", "a").string();
  const std::string user = "user=" + folder_.Write("user.txt", "b").string();
  const auto config = folder_.Write("copy.toml", "size = 7\n").string();
  EXPECT_EQ(Main({"--check-config", "--config", config, "--in", base, "--in", user}).code, 0);
  EXPECT_EQ(read, "base a; b of a");
  ExpectFailure({"--check-config", "--config", config, "--in", user},
                2,
                "user.txt refers to --in base: give that too");
}

TEST_F(StageMainTest, OutputsInTheWrongPlaceAreUsageErrorsBeforeTheStageRuns) {
  spec_.outputs.push_back({"more", "another", Arity::kOptional});
  const auto config = folder_.Write("copy.toml", "size = 7\n");
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"more=/dev/null", "--out more=/dev/null: is a device"},
      {"more=" + folder_.Path().string(), "is a folder"},
      {"more=" + input_.string(), "is the file of --in in="},
      {"more=" + config.string(), "is the file of --config"},
      {"more=" + (folder_ / "./out").string(), "are one file"}};
  for (const auto& [port, message] : cases) {
    ExpectFailure(With({"--config", config.string(), "--out", port}), 2, message, Never);
  }
}

TEST_F(StageMainTest, AReceiptHasNoHashOfAnInputByHash) {
  const std::string listed = folder_.Write("listed.h5", "masks").string();
  spec_.inputs = {{"in", "a file"}, {"masks", "masks", Arity::kAnyNumber, PortKind::kByHash}};
  ASSERT_EQ(Main(With({"--in", "masks=" + listed})).code, 0);
  const auto written = Json("receipt");
  ASSERT_EQ(written["inputs"].size(), 2U);
  for (const auto& entry : written["inputs"]) {
    EXPECT_EQ(entry.contains("xxh3"), entry["name"] != "masks") << entry;
  }
}

// A run of one job of a site, and of another that reads what it wrote.
TEST_F(StageMainTest, AnInputThatIsNotWhatItsJobWroteIsRefused) {
  const auto run =
      [&](const std::string& from, const std::string& job, const Body& body = CopyBody) {
        std::vector<std::string> arguments{"--in", "in=" + from};
        for (const char* name : {"out", "report", "receipt"}) {
          const std::string file = (folder_ / job / name).string();
          arguments.insert(arguments.end(), {"--out", name + ("=" + file) + ".json"});
        }
        return Main(arguments, body);
      };
  const std::string written = (folder_ / "first/out.json").string();
  ASSERT_EQ(run(input_, "first").code, 0);
  ASSERT_EQ(run(written, "second").code, 0);
  WriteFile(written, "jello");
  const std::string message = written + ": is not the file that the job wrote";
  const Result direct = run(written, "second", Never);
  EXPECT_EQ(direct.code, 1);
  EXPECT_THAT(direct.err, testing::HasSubstr(message));
  const Result named = run(input_, "second", CopyAnd([&](StageContext& context) {
                             context.AddInput(written, context.Input("in"));
                           }));
  EXPECT_EQ(named.code, 1);
  EXPECT_THAT(named.err, testing::HasSubstr(message));
  EXPECT_EQ(ReadFile(folder_ / "second/out.json"), "hello");
  spec_.inputs[0].kind = PortKind::kByHash;
  EXPECT_EQ(run(written, "second").code, 0);
}

// The inputs would be waited for, if they were opened.
TEST_F(StageMainTest, InputsOfTheWrongKindAreUsageErrors) {
  const std::string fifo = (folder_ / "fifo").string();
  ASSERT_EQ(mkfifo(fifo.c_str(), 0600), 0);
  spec_.inputs = {{"in", "a file"}, {"data", "a folder", Arity::kOptional, PortKind::kFolder}};
  const std::string folder = folder_.Path().string();
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {{"--in", "in=" + fifo}, "--in in=" + fifo + ": is a FIFO, a file is needed (a file)"},
      {{"--in", "in=/dev/null"}, "is a device, a file is needed"},
      {{"--in", "in=" + folder}, "is a folder, a file is needed"},
      {{"--in", "in=" + input_.string(), "--in", "data=" + input_.string()},
       "is a file, a folder is needed (a folder)"},
      {{"--in", "in=" + input_.string(), "--in", "data=" + fifo}, "is a FIFO, a folder is needed"},
      {{"--in", "in=" + input_.string(), "--config", fifo},
       "--config " + fifo + ": is a FIFO, a file is needed"}};
  for (std::pair<std::vector<std::string>, std::string> item : cases) {
    item.first.insert(item.first.end(), {"--out", "out=" + (folder_ / "out").string()});
    ExpectFailure(item.first, 2, item.second);
  }
  EXPECT_EQ(Main(With({"--in", "data=" + folder})).code, 0);
}

TEST_F(StageMainTest, AFileBesideAnOutputDoesNotReplaceAnythingElse) {
  folder_.Write("a_folder/inside", "");
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"a_folder", "a_folder, written beside --out out: is a folder"},
      {"in.txt", "in.txt, written beside --out out is the file of --in in"},
      {"report", "and " + (folder_ / "report").string() + ", written beside --out out are one"}};
  for (const auto& [name, message] : cases) {
    ExpectFailure(Ports(), 2, message, CopyAnd([&, beside = name](StageContext& context) {
                    WriteFile(context.OutputBeside("out", beside), "new");
                  }));
  }
}

TEST_F(StageMainTest, AFileThatAnInputNamesIsNotOverwritten) {
  const auto named = folder_.Write("named.txt", "more");
  spec_.outputs.push_back({"more", "another", Arity::kOptional});
  const Body body =
      CopyAnd([&](StageContext& context) { context.AddInput(named, context.Input("in")); });
  ExpectFailure(With({"--out", "more=" + named.string()}),
                2,
                "in.txt names; give the output another path",
                body);
  EXPECT_EQ(ReadFile(named), "more");
}

TEST_F(StageMainTest, OutOfMemoryNamesTheInputs) {
  ExpectFailure(Ports(),
                1,
                "out of memory with the inputs in=" + input_.string(),
                [](const Options&, StageContext&) { throw std::bad_alloc(); });
}

TEST_F(StageMainTest, WhateverSaysThatMemoryRanOutIsCalledMemory) {
  const std::vector<std::function<void()>> failures = {
      [] { throw OutOfMemory("a.png"); },
      [] { throw std::system_error(EAGAIN, std::generic_category()); },  // of a new thread
      [] { throw std::system_error(ENOMEM, std::generic_category()); },
      [] { throw std::runtime_error("(-4:Insufficient memory) Failed to allocate 9 bytes"); }};
  for (const auto& fail : failures) {
    const Body body = CopyAnd([&](StageContext&) { fail(); });
    ExpectFailure(Ports(), 1, "out of memory", body);
    ExpectFailure(Ports(), 1, "THREADS=1", body);
  }
}

TEST_F(StageMainTest, AnInputThatCannotBeIsNamedByItsFile) {
  const auto second = folder_.Write("second.txt", "");
  const auto third = folder_.Write("third.txt", "");
  spec_.inputs.push_back({"more", "others", Arity::kMany});
  const auto expect = [&](const std::vector<InputName>& inputs, const std::string& message) {
    const auto more = With({"--in", "more=" + second.string(), "--in", "more=" + third.string()});
    ExpectFailure(more, 1, message + "\n", [&](const Options&, StageContext&) {
      throw InputError(inputs, "holds {} eggs", 3);
    });
  };
  const std::string in = input_.string();
  expect({{"in"}}, in + ": holds 3 eggs; delete it and run make again");
  expect({{"more", 1}}, third.string() + ": holds 3 eggs; delete it and run make again");
  expect({{"more"}, {"in"}},
         second.string() + " (or another of 2), " + in +
             ": holds 3 eggs; delete them and run make again");
}

TEST_F(StageMainTest, AnInputThatADeletionDoesNotMendHasItsOwnRemedy) {
  const std::string message = input_.string() + ": 0 eggs; lay some\n";
  ExpectFailure(Ports(), 1, message, [](const Options&, StageContext&) {
    throw InputError({{"in"}}, InputError::Remedy::kInText, "{} eggs; lay some", 0);
  });
}

TEST_F(StageMainTest, AMissingInputIsNamed) {
  std::filesystem::remove(input_);
  ExpectFailure(Ports(), 1, "in.txt");
}

TEST_F(StageMainTest, EveryErrorHasItsCodeAndCommitsNothing) {
  const auto expect = [&](int code, const auto& error) {
    ExpectFailure(Ports(), code, "broken 1", CopyAnd([&](StageContext&) { throw error; }));
  };
  expect(1, DataError("broken {}", 1));
  expect(2, UsageError("broken {}", 1));
  expect(3, ThresholdError("broken {}", 1));
  expect(1, std::runtime_error("broken 1"));
}

TEST_F(StageMainTest, AFailureLeavesTheOldFilesAndNothingElse) {
  for (const char* name : {"out", "report", "receipt"}) folder_.Write(name, "old");
  const Body fail = CopyAnd([](StageContext&) { throw ThresholdError("too few"); });
  EXPECT_EQ(Main(Ports(), fail).code, 3);
  for (const auto& entry : std::filesystem::directory_iterator(folder_.Path())) {
    EXPECT_EQ(ReadFile(entry.path()), entry.path() == input_ ? "hello" : "old") << entry.path();
  }
}

TEST_F(StageMainTest, TheReportDoesNotKnowTheNumberOfThreads) {
  ASSERT_EQ(Main(With({"--threads", "1"})).code, 0);
  const std::string report = ReadFile(folder_ / "report");
  ASSERT_EQ(Main(With({"--threads", "4"})).code, 0);
  EXPECT_EQ(ReadFile(folder_ / "report"), report);
  EXPECT_EQ(Json("receipt")["threads"], 4);
}

TEST_F(StageMainTest, ARepeatedInputKeepsItsOrderAndAnOptionalOneMayBeMissing) {
  spec_.inputs = {{"in", "files", Arity::kMany}, {"extra", "a file", Arity::kOptional}};
  const auto second = folder_.Write("a=b.txt", " again");
  const Result run = Main(With({"--in", "in=" + second.string()}), JoinBody);
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_EQ(ReadFile(folder_ / "out"), "hello again");
}

TEST_F(StageMainTest, AListOfInputsCountsAsItsLinesInOrder) {
  spec_.inputs = {{"in", "files", Arity::kMany}, {"extra", "files", Arity::kAnyNumber}};
  const auto b = folder_.Write("b=b c.txt", "b");
  const auto a = folder_.Write("a.txt", "a");
  const auto list = folder_.Write("list", b.string() + "\n" + a.string());  // and no newline
  const auto none = folder_.Write("none", "");
  const Result run = Main(
      With({"--in-list", "in=" + list.string(), "--in-list", "extra=" + none.string()}), JoinBody);
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_EQ(ReadFile(folder_ / "out"), "helloba");
  std::vector<std::string> paths;
  const auto receipt = Json("receipt");
  for (const auto& input : receipt["inputs"]) {
    EXPECT_EQ(input["name"], "in");
    paths.push_back(input["path"]);
  }
  EXPECT_THAT(paths, testing::ElementsAre(input_.string(), b.string(), a.string()));
}

TEST_F(StageMainTest, AListOfInputsThatIsNoneIsRefused) {
  spec_.inputs = {{"in", "files", Arity::kMany}};
  const std::string path = input_.string();
  const auto huge = folder_.Write("huge", path);
  std::filesystem::resize_file(huge, (64 << 20) + 1);
  const std::vector<std::tuple<std::string, int, std::string>> cases = {
      {"in=" + folder_.Write("gap", path + "\n\n" + path).string(), 1, "gap:2: a path is needed"},
      {"in=" + folder_.Write("nul", path + '\0').string(), 1, "nul:1: a path is needed"},
      {"in=" + folder_.Write("lost", path + "\n/no/such").string(), 1, "/no/such: input 'in'"},
      {"in=" + huge.string(), 1, "too many"},
      {"in=" + (folder_ / "absent").string(), 1, "absent: the file does not exist"},
      {"in=" + folder_.Path().string(), 2, "is a folder"},
      {"other=" + folder_.Write("good", path).string(), 2, "no such name"},
      {"good", 2, "NAME=PATH"}};
  for (const auto& [text, code, message] : cases) {
    ExpectFailure(With({"--in-list", text}), code, message);
  }
}

TEST_F(StageMainTest, AListOfInputsIsNotOverwritten) {
  const auto list = folder_.Write("report", input_.string() + "\n");
  std::vector<std::string> arguments = Ports();
  arguments[0] = "--in-list";
  arguments[1] = "in=" + list.string();
  EXPECT_EQ(Main(arguments).code, 2);
  EXPECT_EQ(ReadFile(list), input_.string() + "\n");
}

// A mistake in a stage, not of its user.
TEST_F(StageMainTest, AnAbsentInputIsNotMadeUp) {
  spec_.inputs = {{"in", "a file"}, {"extra", "a file", Arity::kOptional}};
  for (const char* name : {"extra", "unheard_of"}) {
    const std::string message = "input '" + std::string(name) + "' is used but";
    ExpectFailure(Ports(), 1, message, CopyAnd([&](StageContext& context) {
                    EXPECT_THROW(context.Input(name), std::logic_error);
                    context.Input(name);
                  }));
  }
}

TEST_F(StageMainTest, AnInputOfAnyNumberMayBeMissingOrRepeated) {
  spec_.inputs = {{"in", "a file"}, {"extra", "files", Arity::kAnyNumber}};
  std::vector<std::string> arguments = Ports();
  for (const std::size_t count : {0U, 1U, 2U}) {
    std::size_t num_seen = 99;
    const Result run =
        Main(arguments,
             CopyAnd([&](StageContext& context) { num_seen = context.Inputs("extra").size(); }));
    EXPECT_EQ(run.code, 0) << run.err;
    EXPECT_EQ(num_seen, count);
    arguments.insert(arguments.end(), {"--in", "extra=" + (folder_ / "in.txt").string()});
  }
}

TEST_F(StageMainTest, TooManySkippedItemsFail) {
  const auto check = [](StageContext& context) { context.CheckSkipped(2, 0.4); };
  ExpectFailure(Ports(), 1, "1 of 2", CopyAnd(check));
}

TEST_F(StageMainTest, SkippedItemsAreFoldedByCauseInTheLogAndListedInTheReport) {
  const Body body = CopyAnd([](StageContext& context) {
    for (int i = 0; i < 120; ++i) context.Skip(fmt::format("rgb/{}.png: truncated", i));
    context.CheckSkipped(1000, 0.2);
  });
  const Result run = Main(Ports(), body);
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.err, testing::HasSubstr("skipped: rgb/0.png: truncated"));
  EXPECT_THAT(run.err, testing::Not(testing::HasSubstr("rgb/1.png")));
  EXPECT_THAT(run.err,
              testing::HasSubstr("120 items skipped: truncated; the first is rgb/0.png\n"));
  const auto report = Json("report");
  EXPECT_EQ(report["num_skipped"], 121);
  EXPECT_EQ(report["skipped"].size(), 121U);
  EXPECT_EQ(report["skipped"][120], "rgb/119.png: truncated");
  EXPECT_THAT(Main(With({"--log-level", "debug"}), body).err,
              testing::HasSubstr("skipped: rgb/119.png: truncated"));
}

TEST_F(StageMainTest, AReportThatTheStageMakesAnewStillListsWhatWasSkipped) {
  const auto report_anew = [](StageContext& context) { context.Report() = {{"num_things", 7}}; };
  const Result run = Main(Ports(), CopyAnd(report_anew));
  ASSERT_EQ(run.code, 0) << run.err;
  const auto report = Json("report");
  EXPECT_EQ(report["num_things"], 7);
  EXPECT_EQ(report["skipped"][0], "one bad item");
}

TEST_F(StageMainTest, ManyCausesDoNotFloodTheLog) {
  const Result run = Main(Ports(), CopyAnd([](StageContext& context) {
                            for (char c = 'a'; c < 'z'; ++c)
                              context.Skip(fmt::format("x.png: cause {}", c));
                          }));
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.err, testing::HasSubstr("cause a"));
  EXPECT_THAT(run.err, testing::Not(testing::HasSubstr("cause y")));
  EXPECT_THAT(run.err, testing::HasSubstr("16 more causes"));
}

}  // namespace nightmap::stage_main_test
