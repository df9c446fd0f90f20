// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/hdf5_file.h"

#include <limits>
#include <memory>

#include "pipeline/base/error.h"
#include "tests/test_data.h"

namespace nightmap::hdf5_file_test {

class Hdf5FileTest : public testing::Test {
 protected:
  // The smallest and the largest value of the type come back, and so does a list of none.
  template <typename T>
  void ExpectRoundTrip() const {
    using Limits = std::numeric_limits<T>;
    const Array<T> array{2, 3, {0, 1, 2, Limits::lowest(), Limits::max(), 5}};
    Hdf5Writer writer(path_, "thing", 1, "", "");
    writer.Write("group/inner/array", array);
    writer.WriteList<T>("none", {});
    writer.Close();
    const Hdf5Reader reader(path_, "thing", 1);
    const auto read = reader.Read<T>("group/inner/array", 3);
    EXPECT_EQ(read.rows, 2U);
    EXPECT_EQ(read.cols, 3U);
    EXPECT_EQ(read.values, array.values);
    EXPECT_TRUE(reader.ReadList<T>("none").empty());
    EXPECT_TRUE(reader.Has("none"));
    EXPECT_FALSE(reader.Has("more"));
  }
  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "a.h5";
};

TEST_F(Hdf5FileTest, EveryTypeReadsBack) {
  ExpectRoundTrip<std::uint8_t>();
  ExpectRoundTrip<std::int32_t>();
  ExpectRoundTrip<std::uint32_t>();
  ExpectRoundTrip<std::int64_t>();
  ExpectRoundTrip<float>();
  ExpectRoundTrip<double>();
}

TEST_F(Hdf5FileTest, TextsReadBack) {
  Hdf5Writer writer(path_, "thing", 1, "size = 1\n", "metres");
  writer.WriteText("note", "two\nlines");
  writer.WriteText("empty", "");
  writer.Close();
  const Hdf5Reader reader(path_, "thing", 1);
  EXPECT_EQ(reader.ReadText("config"), "size = 1\n");
  EXPECT_EQ(reader.ReadText("units"), "metres");
  EXPECT_EQ(reader.ReadText("note"), "two\nlines");
  EXPECT_EQ(reader.ReadText("empty"), "");
  NIGHTMAP_EXPECT_ERROR(DataError, reader.ReadText("more"), "a.h5: field 'more' is missing");
}

TEST_F(Hdf5FileTest, NoTextIsLost) {
  const std::string longest(64000, 'x');
  const std::string too_long(70000, 'x');
  {
    Hdf5Writer writer(path_, "thing", 1, "", "");
    writer.WriteText("note", longest);
    NIGHTMAP_EXPECT_ERROR(
        DataError, writer.WriteText("more", too_long), "a.h5: cannot write text 'more' of 70000");
    writer.Close();
  }
  EXPECT_EQ(Hdf5Reader(path_, "thing", 1).ReadText("note"), longest);
  NIGHTMAP_EXPECT_ERROR(
      DataError, Hdf5Writer(path_, "thing", 1, too_long, ""), "a.h5: cannot write text 'config'");
}

TEST_F(Hdf5FileTest, ErrorsNameFileAndField) {
  Hdf5Writer writer(path_, "thing", 3, "", "");
  writer.WriteList<double>("nan", {1, std::numeric_limits<double>::quiet_NaN()});
  writer.WriteList<float>("infinite", {-std::numeric_limits<float>::infinity()});
  writer.WriteList<std::int32_t>("list", {1, 2});
  writer.Close();
  NIGHTMAP_EXPECT_ERROR(
      DataError, Hdf5Reader(path_, "other", 3), "a.h5: field 'format' is 'thing'");
  NIGHTMAP_EXPECT_ERROR(DataError, Hdf5Reader(path_, "thing", 2), "a.h5: field 'version' is 3");
  const Hdf5Reader reader(path_, "thing", 4);  // a program reads the versions before its own
  NIGHTMAP_EXPECT_ERROR(DataError, reader.ReadList<double>("nan"), "a.h5: field 'nan' holds NaN");
  NIGHTMAP_EXPECT_ERROR(DataError, reader.ReadList<float>("infinite"), "a.h5: field 'infinite'");
  NIGHTMAP_EXPECT_ERROR(
      DataError, reader.ReadList<float>("list"), "a.h5: field 'list' has another element type");
  NIGHTMAP_EXPECT_ERROR(
      DataError, reader.Read<std::int32_t>("list", 2), "a.h5: field 'list' has 1 columns, 2");
  NIGHTMAP_EXPECT_ERROR(DataError, reader.ReadList<float>("x/y"), "a.h5: field 'x/y' is missing");
}

TEST_F(Hdf5FileTest, NoTruncationIsReadAsAFile) {
  Hdf5Writer writer(path_, "thing", 1, "config", "units");
  writer.WriteList<double>("list", std::vector<double>(300, 1.5));
  writer.Close();
  const std::string bytes = ReadBytes(path_);
  for (std::size_t size = 0; size < bytes.size(); size += 97) {
    folder_.Write("cut.h5", bytes.substr(0, size));
    NIGHTMAP_EXPECT_ERROR(
        DataError, Hdf5Reader(folder_ / "cut.h5", "thing", 1).ReadList<double>("list"), "cut.h5");
  }
  folder_.Write("text.h5", "not HDF5 at all");
  NIGHTMAP_EXPECT_ERROR(DataError, Hdf5Reader(folder_ / "text.h5", "thing", 1), "text.h5");
}

TEST_F(Hdf5FileTest, WhatCannotBeWrittenIsNamed) {
  NIGHTMAP_EXPECT_ERROR(DataError,
                        Hdf5Writer(folder_ / "none/a.h5", "thing", 1, "", ""),
                        "none/a.h5: cannot create: No such file");
  Hdf5Writer writer(path_, "thing", 1, "", "");
  NIGHTMAP_EXPECT_ERROR(DataError,
                        writer.Write("array", Array<float>{2, 2, {1, 2, 3}}),
                        "a.h5: array 'array' has 3 values");
  writer.WriteList<float>("list", {1});
  NIGHTMAP_EXPECT_ERROR(
      DataError, writer.WriteList<float>("list", {2}), "a.h5: cannot write array");
}

TEST_F(Hdf5FileTest, AListLeftInTheFileIsReadInParts) {
  Hdf5Writer writer(path_, "thing", 1, "", "");
  writer.WriteList<std::int32_t>("a/list", {10, 11, 12, 13, 14});
  writer.WriteList<float>("empty", {});
  writer.WriteList<float>("nan", {1, std::numeric_limits<float>::quiet_NaN(), 3});
  writer.Write("matrix", Array<float>{1, 2, {1, 2}});
  writer.Close();
  auto reader = std::make_unique<Hdf5Reader>(path_, "thing", 1);
  const auto list = reader->LeaveInFile<std::int32_t>("a/list");
  const auto empty = reader->LeaveInFile<float>("empty");
  const auto nan = reader->LeaveInFile<float>("nan");
  NIGHTMAP_EXPECT_ERROR(ArtifactError, reader->LeaveInFile<float>("a/list"), "another element");
  NIGHTMAP_EXPECT_ERROR(ArtifactError, reader->LeaveInFile<float>("matrix"), "has 2 columns");
  reader.reset();  // the lists keep the file open
  const auto read = [](const auto& from, std::size_t begin, std::size_t end, auto values) {
    from.Read(begin, end, &values);
    return values;
  };
  const std::vector<std::int32_t> ints(2);  // that the read ones replace
  const std::vector<float> floats(2);
  EXPECT_EQ(list.Size(), 5U);
  EXPECT_EQ(read(list, 1, 4, ints), (std::vector<std::int32_t>{11, 12, 13}));
  EXPECT_EQ(read(list, 0, 5, ints).size(), 5U);
  EXPECT_TRUE(read(list, 5, 5, ints).empty());
  EXPECT_TRUE(read(empty, 0, 0, floats).empty());
  EXPECT_EQ(read(nan, 2, 3, floats), (std::vector<float>{3}));
  NIGHTMAP_EXPECT_ERROR(ArtifactError, read(nan, 0, 3, floats), "a.h5: field 'nan' holds NaN");
  NIGHTMAP_EXPECT_ERROR(
      ArtifactError, read(list, 4, 6, ints), "a.h5: field 'a/list' has no elements");
  NIGHTMAP_EXPECT_ERROR(ArtifactError, read(list, 3, 2, ints), "has no elements 3 to 2");
  std::filesystem::resize_file(path_, 100);
  NIGHTMAP_EXPECT_ERROR(
      ArtifactError, read(list, 0, 5, ints), "a/list' cannot be read (truncated file?)");
}

}  // namespace nightmap::hdf5_file_test
