// SPDX-License-Identifier: Apache-2.0
// Files that HDF5 itself opens without complaint, but that no Hdf5Writer wrote.
#include <array>
#include <cstring>
#include <functional>

#include "pipeline/base/error.h"
#include "pipeline/io/hdf5_file.h"
#include "pipeline/io/hdf5_handle.h"
#include "tests/test_data.h"

namespace nightmap::hdf5_hostile_test {

class Hdf5HostileTest : public testing::Test {
 protected:
  void SetUp() override {
    Hdf5Writer writer(path_, "thing", 1, "size = 1\n", "metres");
    writer.WriteList<double>("group/list", {1, 2, 3});
    writer.Close();
    bytes_ = ReadBytes(path_);
  }

  // The file of SetUp after `change`, whose argument is the open file.
  void Change(const std::function<void(hid_t)>& change) {
    folder_.Write("a.h5", bytes_);
    const Hdf5Handle file(H5Fopen(path_.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose);
    ASSERT_TRUE(file.Valid());
    change(file);
  }

  // Another attribute of that name, of any type and shape.
  void ReplaceAttribute(const char* name, hid_t type, hid_t space, const void* value) {
    Change([&](hid_t file) {
      ASSERT_GE(H5Adelete(file, name), 0);
      const Hdf5Handle attribute(H5Acreate2(file, name, type, space, H5P_DEFAULT, H5P_DEFAULT),
                                 H5Aclose);
      ASSERT_TRUE(attribute.Valid());
      ASSERT_GE(H5Awrite(attribute, type, value), 0);
    });
  }

  // Another array of that name, of any shape and storage; nothing is written into it.
  void ReplaceArray(hid_t space, hid_t properties) {
    Change([&](hid_t file) {
      ASSERT_GE(H5Ldelete(file, "group/list", H5P_DEFAULT), 0);
      const Hdf5Handle dataset(
          H5Dcreate2(
              file, "group/list", H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, properties, H5P_DEFAULT),
          H5Dclose);
      ASSERT_TRUE(dataset.Valid());
    });
  }

  void ExpectArrayRefused(hid_t space, hid_t properties, const std::string& text) {
    ReplaceArray(space, properties);
    NIGHTMAP_EXPECT_ERROR(DataError,
                          Hdf5Reader(path_, "thing", 1).Read<double>("group/list"),
                          "a.h5: field 'group/list' declares " + text + " values");
  }

  void ExpectListRefused(const std::string& text) const {
    NIGHTMAP_EXPECT_ERROR(DataError, ReadTheList(), "a.h5: field 'group/list' " + text);
  }

  std::vector<double> ReadTheList() const {
    return Hdf5Reader(path_, "thing", 1).ReadList<double>("group/list");
  }

  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "a.h5";
  std::string bytes_;
  Hdf5Handle scalar_{H5Screate(H5S_SCALAR), H5Sclose};
};

Hdf5Handle Matrix(hsize_t rows, hsize_t cols) {
  const hsize_t sizes[2] = {rows, cols};
  return {H5Screate_simple(2, sizes, nullptr), H5Sclose};
}

Hdf5Handle ArrayProperties() { return {H5Pcreate(H5P_DATASET_CREATE), H5Pclose}; }

TEST_F(Hdf5HostileTest, OneIntegerOfAnySizeIsAVersion) {
  for (const hid_t type : {H5T_NATIVE_INT8, H5T_NATIVE_UINT16, H5T_NATIVE_INT64, H5T_STD_I32BE}) {
    const std::array<char, 8> one = {1, 0, 0, type == H5T_STD_I32BE ? char{1} : char{0}};
    std::array<char, 8> value = one;
    if (type == H5T_STD_I32BE) value[0] = 0;
    ReplaceAttribute("version", type, scalar_, value.data());
    EXPECT_EQ(ReadTheList().size(), 3U);
  }
}

TEST_F(Hdf5HostileTest, AVersionThatIsNotOneIntegerIsNamed) {
  const std::vector<std::int64_t> many(4000, 1);
  const auto expect_refused = [&](const std::string& text) {
    NIGHTMAP_EXPECT_ERROR(DataError, ReadTheList(), "a.h5: field 'version' " + text);
  };
  ReplaceAttribute("version", H5T_NATIVE_INT64, Matrix(1000, 4), many.data());
  expect_refused("is not one integer");
  ReplaceAttribute("version", H5T_NATIVE_DOUBLE, scalar_, many.data());
  expect_refused("is not one integer");
  const Hdf5Handle compound(H5Tcreate(H5T_COMPOUND, 16), H5Tclose);
  H5Tinsert(compound, "a", 0, H5T_NATIVE_INT64);
  H5Tinsert(compound, "b", 8, H5T_NATIVE_INT64);
  ReplaceAttribute("version", compound, scalar_, many.data());
  expect_refused("is not one integer");
  const std::int64_t huge = (std::int64_t{1} << 32) + 1;  // 1 if it were cut to 32 bits
  ReplaceAttribute("version", H5T_NATIVE_INT64, scalar_, &huge);
  expect_refused("is 4294967297");
  Change([](hid_t file) { H5Adelete(file, "version"); });
  expect_refused("is missing");
}

TEST_F(Hdf5HostileTest, ATextThatIsNotOneOfFixedLengthIsNamed) {
  for (const char* name : {"format", "config"}) {
    const auto expect_refused = [&](const std::string& text) {
      NIGHTMAP_EXPECT_ERROR(DataError,
                            Hdf5Reader(path_, "thing", 1).ReadText("config"),
                            std::string("a.h5: field '") + name + "' " + text);
    };
    const Hdf5Handle variable(H5Tcopy(H5T_C_S1), H5Tclose);
    H5Tset_size(variable, H5T_VARIABLE);
    const char* text = "thing";
    ReplaceAttribute(name, variable, scalar_, &text);
    expect_refused("is not one text");
    const Hdf5Handle fixed(H5Tcopy(H5T_C_S1), H5Tclose);
    H5Tset_size(fixed, 6);
    const std::string many(6 * 10000, 'x');
    ReplaceAttribute(name, fixed, Matrix(100, 100), many.data());
    expect_refused("is not one text");
    ReplaceAttribute(name, fixed, scalar_, "th\0ng");
    expect_refused("is not a text in UTF-8");
    ReplaceAttribute(name, fixed, scalar_, "th\xffng");
    expect_refused("is not a text in UTF-8");
    ReplaceAttribute(name, fixed, scalar_, "\x1b[2Jx");
    expect_refused("is not a text in UTF-8");
    ReplaceAttribute(name, H5T_NATIVE_INT64, scalar_, many.data());
    expect_refused("is not one text");
  }
}

TEST_F(Hdf5HostileTest, SizesThatTheFileDoesNotHoldTakeNoMemory) {
  // Storage that is made when it is written: a file of a few kB declares terabytes.
  ExpectArrayRefused(Matrix(1'000'000'000'000, 1), ArrayProperties(), "1000000000000 x 1");
  const Hdf5Handle chunked = ArrayProperties();
  const hsize_t chunk[2] = {1, 1};
  H5Pset_chunk(chunked, 2, chunk);
  ExpectArrayRefused(Matrix(hsize_t{1} << 32, hsize_t{1} << 32),
                     chunked,
                     "4294967296 x 4294967296");                 // 0 values in 64 bits
  ExpectArrayRefused(Matrix(2, 1), ArrayProperties(), "2 x 1");  // never written
  ExpectArrayRefused(Matrix(0, hsize_t{1} << 40), ArrayProperties(), "0 x 1099511627776");
}

TEST_F(Hdf5HostileTest, OtherStorageThanAPlainPieceOfTheFileIsRefused) {
  const Hdf5Handle chunked = ArrayProperties();
  const hsize_t chunk[2] = {2, 1};
  H5Pset_chunk(chunked, 2, chunk);
  ExpectArrayRefused(Matrix(1'000'000'000'000, 1), chunked, "1000000000000 x 1");
  ExpectArrayRefused(Matrix(3, 1), chunked, "3 x 1");
  const Hdf5Handle compressed = ArrayProperties();
  H5Pset_chunk(compressed, 2, chunk);
  H5Pset_deflate(compressed, 9);
  ExpectArrayRefused(Matrix(3, 1), compressed, "3 x 1");
  const Hdf5Handle external = ArrayProperties();
  folder_.Write("other.bin", std::string(24, '\0'));
  H5Pset_external(external, (folder_ / "other.bin").c_str(), 0, 24);
  ExpectArrayRefused(Matrix(3, 1), external, "3 x 1");
  const Hdf5Handle virtual_array = ArrayProperties();
  H5Pset_virtual(virtual_array, Matrix(3, 1), "other.h5", "list", Matrix(3, 1));
  ExpectArrayRefused(Matrix(3, 1), virtual_array, "3 x 1");
}

// Many bytes of a file mean nothing; all others matter.
TEST_F(Hdf5HostileTest, NoFlippedBitIsReadAsOtherContent) {
  int num_refused = 0;
  for (std::size_t at = 0; at < bytes_.size(); ++at) {
    std::string damaged = bytes_;
    damaged[at] = static_cast<char>(damaged[at] ^ (1 << (at % 8)));
    folder_.Write("a.h5", damaged);
    try {
      const Hdf5Reader reader(path_, "thing", 1);
      EXPECT_EQ(reader.ReadList<double>("group/list"), (std::vector<double>{1, 2, 3})) << at;
      EXPECT_EQ(reader.ReadText("config") + reader.ReadText("units"), "size = 1\nmetres") << at;
    } catch (const DataError& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("a.h5"));
      ++num_refused;
    }
  }
  EXPECT_GT(num_refused, 24);
}

TEST_F(Hdf5HostileTest, ArraysOfAnotherPlaceOrShapeAreRefused) {
  Change([&](hid_t file) {
    Hdf5Writer writer(folder_ / "b.h5", "thing", 1, "size = 1\n", "metres");
    writer.WriteList<double>("other", {3, 2, 1});
    writer.Close();
    const Hdf5Handle other(H5Fopen((folder_ / "b.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT),
                           H5Fclose);
    H5Ldelete(file, "group/list", H5P_DEFAULT);
    H5Ocopy(other, "other", file, "group/list", H5P_DEFAULT, H5P_DEFAULT);
  });
  ExpectListRefused("is not as it was written");
}

TEST_F(Hdf5HostileTest, AFileWithoutHashesIsRefused) {
  Change([](hid_t file) { H5Adelete(file, "xxh3"); });
  NIGHTMAP_EXPECT_ERROR(
      DataError, ReadTheList(), "a.h5: field 'xxh3' is missing: an older nightmap");
  Change([](hid_t file) { H5Adelete_by_name(file, "group/list", "xxh3", H5P_DEFAULT); });
  NIGHTMAP_EXPECT_ERROR(
      DataError, ReadTheList(), "a.h5: field 'xxh3' is missing: an older nightmap");
}

TEST_F(Hdf5HostileTest, AnotherTextIsRefused) {
  const Hdf5Handle fixed(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(fixed, 6);
  for (const std::string name : {"config", "units"}) {
    ReplaceAttribute(name.c_str(), fixed, scalar_, "thing");
    NIGHTMAP_EXPECT_ERROR(DataError,
                          Hdf5Reader(path_, "thing", 1).ReadText(name),
                          "a.h5: field '" + name + "' is not as it was written");
  }
}

TEST_F(Hdf5HostileTest, AnOlderVersionThanWasWrittenIsRefused) {
  const int version = 1;
  Hdf5Writer writer(folder_ / "b.h5", "thing", 2, "", "");
  writer.Close();
  bytes_ = ReadBytes(folder_ / "b.h5");
  ReplaceAttribute("version", H5T_NATIVE_INT, scalar_, &version);
  NIGHTMAP_EXPECT_ERROR(
      DataError, Hdf5Reader(path_, "thing", 2), "field 'version' is not as it was");
}

TEST_F(Hdf5HostileTest, LinksAreNotFollowed) {
  std::filesystem::copy_file(path_, folder_ / "b.h5");
  Change([](hid_t file) {
    H5Ldelete(file, "group/list", H5P_DEFAULT);
    H5Lcreate_external("b.h5", "/group/list", file, "group/list", H5P_DEFAULT, H5P_DEFAULT);
  });
  ExpectListRefused("is a link to elsewhere");
  Change([](hid_t file) {
    H5Lmove(file, "group", file, "moved", H5P_DEFAULT, H5P_DEFAULT);
    H5Lcreate_external("b.h5", "/group", file, "group", H5P_DEFAULT, H5P_DEFAULT);
  });
  ExpectListRefused("is a link to elsewhere");
  Change([](hid_t file) {
    H5Ldelete(file, "group/list", H5P_DEFAULT);
    H5Lcreate_soft("/group/list", file, "group/list", H5P_DEFAULT, H5P_DEFAULT);
  });
  ExpectListRefused("is a link to elsewhere");
  Change([](hid_t file) { H5Ldelete(file, "group", H5P_DEFAULT); });
  ExpectListRefused("is missing");
}

TEST_F(Hdf5HostileTest, AGroupOrATypeIsNoArray) {
  NIGHTMAP_EXPECT_ERROR(DataError,
                        Hdf5Reader(path_, "thing", 1).ReadList<double>("group"),
                        "a.h5: field 'group' is missing");
  Change([](hid_t file) {
    H5Ldelete(file, "group/list", H5P_DEFAULT);
    const Hdf5Handle type(H5Tcopy(H5T_NATIVE_DOUBLE), H5Tclose);
    H5Tcommit2(file, "group/list", type, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  });
  ExpectListRefused("is missing");
}

}  // namespace nightmap::hdf5_hostile_test
