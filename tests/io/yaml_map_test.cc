// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/yaml_map.h"

#include <fmt/format.h>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "tests/test_data.h"

namespace nightmap::yaml_map_test {

class YamlMapTest : public testing::Test {
 protected:
  YamlMap Read(const std::string& text) const {
    WriteFile(path_, text);
    return YamlMap(path_);
  }
  void ExpectRefused(const std::string& text, const std::string& line_and_reason) const {
    NIGHTMAP_EXPECT_ERROR(DataError, Read(text), path_.string() + ":" + line_and_reason);
  }

  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_.Path() / "a.yaml";
};

std::string Repeated(const std::string& text, int num) {
  std::string all;
  for (int i = 0; i < num; ++i) all += text;
  return all;
}

// One mapping, as programs and people write it.
TEST_F(YamlMapTest, AllSpellingsOfYamlAreOneMapping) {
  for (const char* text :
       {"word: map\nnumber: 0.5\nlist: [1, -2.5, 0]\nflag: 1\n",
        "word: map\r\nnumber: 5e-1\r\nlist:\r\n- 1\r\n- -2.5\r\n- 0\r\nflag: 1\r\n",
        "flag: true\nlist:\n- 1.0\n- -2.5\n- 0.0\nnumber: 0.5\nword: map\n...\n",
        "%YAML 1.1\n---\n'word': \"map\"\nnumber: +0.5\nlist: [+1, -2.5, -0.0,]\nflag: YES\n",
        "\xEF\xBB\xBF---\n\"word\": 'map' # a\nnumber: .5\nlist:\n  - 1\n  # b\n  - -2.5\n  - "
        "0\nflag: On\n",
        "{word: map, number: 0.5, list: [1, -2.5, 0], flag: True}",
        "---\n---\n? word\n: >-\n  map\nnumber: !!float '0.5'\nlist: &l [1, -2.5, 0]\nflag: y\nm: "
        "*l\n---\n",
        "%TAG ! tag:example.org,2000:\n---\nword: !w map\nnumber: 0.50\nlist: !l\n - 1.\n - "
        "-25e-1\n - 0\nflag: 1.0\n"}) {
    const YamlMap map = Read(text);
    EXPECT_EQ(map.Text("word"), "map") << text;
    EXPECT_EQ(map.Number("number", 0, 1), 0.5) << text;
    EXPECT_EQ(map.Numbers("list"), (std::vector<double>{1, -2.5, 0})) << text;
    EXPECT_TRUE(map.Flag("flag")) << text;
    EXPECT_FALSE(map.Has("absent"));
  }
  for (const char* no : {"0", "false", "False", "no", "off", "N"}) {
    EXPECT_FALSE(Read(fmt::format("flag: {}\n", no)).Flag("flag")) << no;
  }
}

TEST_F(YamlMapTest, WhatCannotBeNamesFileAndLine) {
  const auto number = [&](const std::string& text) {
    Read("a: 1\nb: " + text + "\n").Number("b", 0, 1);
  };
  const std::string line_2 = path_.string() + ":2: ";
  for (const char* text : {".nan", "NaN", ".inf", "-inf", "1e999", "0.5 m", "0,5", "one", "''"}) {
    NIGHTMAP_EXPECT_ERROR(DataError, number(text), line_2 + "b is '", "not a finite number");
  }
  for (const char* text : {"", "~", "null"}) {
    NIGHTMAP_EXPECT_ERROR(DataError, number(text), line_2 + "b has no value");
  }
  for (const char* text : {"[0.5]", "{c: 0.5}"}) {
    NIGHTMAP_EXPECT_ERROR(DataError, number(text), line_2 + "b is not a single value");
  }
  NIGHTMAP_EXPECT_ERROR(DataError, number("2"), line_2 + "b is 2, not in [0, 1]");
  const YamlMap map = Read("a: 1\nb: [1, x]\nc: [{d: 2}, 3]\n\ne: maybe\n");
  NIGHTMAP_EXPECT_ERROR(DataError, map.Number("z", 0, 1), ":1: missing key 'z': add it");
  NIGHTMAP_EXPECT_ERROR(DataError, map.Numbers("a"), ":1: a is not a list");
  NIGHTMAP_EXPECT_ERROR(DataError, map.Numbers("b"), ":2: b is 'x', not a finite number");
  NIGHTMAP_EXPECT_ERROR(DataError, map.Maps("c"), ":3: expected keys and values");
  NIGHTMAP_EXPECT_ERROR(DataError, map.Flag("e"), ":5: e is 'maybe': write 0 or 1");
  NIGHTMAP_EXPECT_ERROR(
      DataError, map.CheckKeys({"a", "b", "c"}), ":5: unknown key 'e'; known: a, b");
  EXPECT_NO_THROW(map.CheckKeys({"a", "b", "c", "e"}));
}

TEST_F(YamlMapTest, DamageIsRefused) {
  ExpectRefused("", "1: expected one YAML document");
  ExpectRefused("# a comment\n", "1: expected one YAML document");
  ExpectRefused("a: 1\n---\na: 1\n", "1: expected one YAML document");
  ExpectRefused("- a\n", "1: expected keys and values");
  ExpectRefused("a\n", "1: expected keys and values");
  ExpectRefused("a: 1\nb: 2\na: 3\n", "3: key 'a' appears twice");
  ExpectRefused("a: 1\n[b]: 2\n", "2: a key is not a single word");
  ExpectRefused("a: 1\n\tb: 2\n", "2: not valid YAML: ");
  ExpectRefused("a: 1\nb: [2\n", "3: not valid YAML: ");
  ExpectRefused("a: 1\nb: *c\n", "2: not valid YAML: ");
  ExpectRefused("%YAML 3.0\n---\na: 1\n", "1: not valid YAML: ");
  ExpectRefused("a: 1\nb: caf\xE9\n", "2: not UTF-8");
  NIGHTMAP_EXPECT_ERROR(DataError, Read(std::string("a: 1\nb\0: 2\n", 11)), path_.string() + ":2");
  NIGHTMAP_EXPECT_ERROR(DataError, YamlMap(folder_.Path() / "none.yaml"), "none.yaml");
  NIGHTMAP_EXPECT_ERROR(DataError, YamlMap(folder_.Path()), folder_.Path().string());
}

// Texts that make other parsers take all memory, all time or all of the stack.
TEST_F(YamlMapTest, BombsAreRefusedOrHarmless) {
  for (const char* nested : {"[", "{", "- ", "? ", "[{a: "}) {
    NIGHTMAP_EXPECT_ERROR(DataError, Read("a: 1\n" + Repeated(nested, 50'000)), "not valid YAML");
  }
  std::string doubled = "a0: &a0 [x, x]\n";
  for (int i = 1; i < 100; ++i) {
    doubled += fmt::format("a{0}: &a{0} [*a{1}, *a{1}]\n", i, i - 1);
  }
  const YamlMap map = Read(doubled);
  NIGHTMAP_EXPECT_ERROR(DataError, map.Numbers("a99"), "a99 is not a single value");
  NIGHTMAP_EXPECT_ERROR(DataError, Read("a: &a [*a]\n").Numbers("a"), "a is not a single value");
  NIGHTMAP_EXPECT_ERROR(DataError, Read("a: &a {b: *a}\n").Text("a"), "a is not a single value");
  EXPECT_EQ(Read("a: 1\n" + Repeated("#\n", 500'000)).Text("a"), "1");
  ExpectRefused("a: 1\n" + Repeated("#\n", 530'000),
                " 1060005 bytes, a YAML file has at most 1048576");
}

}  // namespace nightmap::yaml_map_test
