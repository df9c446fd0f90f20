// SPDX-License-Identifier: Apache-2.0
#include "pipeline/base/options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/base/error.h"

namespace nightmap {
namespace options_test {

struct Options {
  bool flag = true;
  int count = 3;
  double size_m = 0.5;
  std::string kind = "sift";
  std::vector<int> offsets = {1, 2};
  void Register(OptionList& list) {
    list.Add("flag", &flag, "a flag");
    list.Add("count", &count, Range(1, 10), "a count");
    list.Add("size_m", &size_m, Range(0, 1), "a size");
    list.Add("kind", &kind, {"sift", "orb"}, "a choice");
    list.Add("offsets", &offsets, Range(1, 9), "a list");
  }
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

TEST(Options, OwnOptionsStandBesideThoseOfASharedStruct) {
  Options shared;
  int own = 1;
  OptionList list = RegisterOptions(shared);
  list.ContinueAfter("count");
  list.Add("own", &own, Range(0, 9), "an option of the stage");
  list.ContinueAfter("offsets");
  list.Add("last", &own, Range(0, 9), "an option of the stage");
  EXPECT_EQ(list.ToToml(),
            "flag = true\ncount = 3\nown = 1\nsize_m = 0.5\nkind = \"sift\"\noffsets = [1, 2]\n"
            "last = 1\n");
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

}  // namespace options_test
}  // namespace nightmap
