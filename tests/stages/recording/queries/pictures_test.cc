// SPDX-License-Identifier: Apache-2.0
// Plain pictures as queries: which they are, when, and with what cameras.
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <map>

#include "pipeline/base/error.h"
#include "pipeline/io/image_io.h"
#include "pipeline/recording/inspect_frames.h"
#include "pipeline/recording/read_sequence.h"
#include "stages/recording/queries/picture_cameras.h"
#include "stages/recording/queries/queries.h"
#include "tests/test_data.h"

namespace nightmap::pictures_test {

constexpr std::int64_t kSecond_ns = 1'000'000'000;
constexpr const char* kCsvHeader = "picture,width,height,fx,fy,cx,cy,k1,k2,p1,p2,k3\n";

// Writes a picture in the format the name says, of one value, with attributes as OpenImageIO names
// them.
void WritePicture(const std::filesystem::path& path,
                  int width,
                  int height,
                  const std::map<std::string, float>& attributes = {},
                  int num_channels = 3) {
  std::filesystem::create_directories(path.parent_path());
  OIIO::ImageSpec spec(width, height, num_channels, OIIO::TypeDesc::UINT8);
  for (const auto& [name, value] : attributes) {
    const bool is_real = name == "Exif:FocalLength" || name == "Exif:FocalPlaneXResolution";
    if (is_real) {
      spec.attribute(name, value);
    } else {
      spec.attribute(name, static_cast<int>(value));
    }
  }
  const std::vector<unsigned char> pixels(static_cast<std::size_t>(width) *
                                              static_cast<std::size_t>(height) *
                                              static_cast<std::size_t>(num_channels),
                                          100);
  auto output = OIIO::ImageOutput::create(path.string());
  ASSERT_TRUE(output);
  ASSERT_TRUE(output->open(path.string(), spec));
  ASSERT_TRUE(output->write_image(OIIO::TypeDesc::UINT8, pixels.data()));
  ASSERT_TRUE(output->close());
}

// A data folder with the site "site", of one camera and without sequences.
class PicturesTest : public testing::Test {
 protected:
  PicturesTest() {
    site_.root = "site";
    site_.cameras.emplace_back().camera_id = "map";
    site_.cameras[0].color = {.width = 32, .height = 24, .fx = 30, .fy = 30, .cx = 15, .cy = 11};
    std::filesystem::create_directories(Site() / "");
  }

  std::filesystem::path Site() const { return folder_ / "data/site"; }
  std::filesystem::path Data() const { return folder_ / "data"; }

  SequenceConfig& AddQuery(const std::string& pictures, int camera_idx = kOwnCameras) {
    SequenceConfig& query = site_.queries.emplace_back();
    query.layout = "pictures";
    query.pictures = pictures;
    query.camera_idx = camera_idx;
    query.source = fmt::format("site.toml:{}", 10 * site_.queries.size());
    return query;
  }
  std::vector<RawSequence> Read() const { return ReadQuerySequences(site_, Data()); }
  std::vector<std::string> Paths() const {
    std::vector<std::string> paths;
    for (const RawSequence& sequence : Read()) {
      for (const RawFrame& frame : sequence.frames) paths.push_back(frame.color.path);
    }
    return paths;
  }
  // The camera of each picture.
  std::vector<Camera> Cameras() {
    sequences_ = Read();
    cameras_ = FindPictureCameras(site_, Data(), options_, &sequences_);
    std::vector<Camera> cameras;
    for (const RawSequence& sequence : sequences_) {
      for (const RawFrame& frame : sequence.frames) {
        cameras.push_back(cameras_.at(static_cast<std::size_t>(frame.camera_idx)).color);
      }
    }
    return cameras;
  }
  std::vector<RawFrame> Inspect() {
    Cameras();
    Progress progress("test", false);
    HashCache files(folder_ / "hashes.csv", Data());
    InspectFrames(cameras_, Data(), files, progress, 2, &sequences_);
    return sequences_.at(0).frames;
  }

  TemporaryFolder folder_;
  SiteConfig site_;
  QueriesOptions options_{.max_picture_mpx = 100};
  std::vector<RawSequence> sequences_;
  std::vector<RgbdCamera> cameras_;
};

using Strings = std::vector<std::string>;

TEST_F(PicturesTest, AFolderIsItsPicturesByName) {
  for (const char* name : {"b.JPG", "a.png", "c 1.jpeg", "._b.jpg", "notes.md", "cameras.csv"}) {
    folder_.Write(std::string("data/site/lobby/") + name, "x");
  }
  std::filesystem::create_directories(Site() / "lobby/more");
  AddQuery("lobby");
  EXPECT_EQ(Paths(), (Strings{"site/lobby/a.png", "site/lobby/b.JPG", "site/lobby/c 1.jpeg"}));
}

TEST_F(PicturesTest, AListIsInItsOwnOrderAndRelativeToItself) {
  folder_.Write("data/site/lists/one.txt", "# two pictures\n../b c.jpg\r\n\n  sub/a.png  \n");
  AddQuery("lists/one.txt");
  EXPECT_EQ(Paths(), (Strings{"site/b c.jpg", "site/lists/sub/a.png"}));
  folder_.Write("data/site/lists/one.txt", "a.png\n/b.png\n");
  NIGHTMAP_EXPECT_ERROR(DataError, Read(), "one.txt:2: '/b.png' must be relative to the list");
  folder_.Write("data/site/lists/one.txt", "# nothing\n");
  NIGHTMAP_EXPECT_ERROR(DataError, Read(), "one.txt: no pictures");
}

TEST_F(PicturesTest, OneFileMayLieOutsideOfTheDataFolder) {
  folder_.Write("photos/start.jpg", "x");
  AddQuery("../../photos/start.jpg");
  EXPECT_EQ(Paths(), Strings{"../photos/start.jpg"});
  // The path as the system resolves it, also when the data folder is a link.
  std::filesystem::rename(Data(), folder_ / "disk");
  std::filesystem::create_directories(folder_ / "elsewhere");
  std::filesystem::rename(folder_ / "disk", folder_ / "elsewhere/disk");
  std::filesystem::create_directory_symlink("elsewhere/disk", Data());
  site_.queries[0].pictures = "../../../photos/start.jpg";
  EXPECT_EQ(Paths(), Strings{"../../photos/start.jpg"});
}

TEST_F(PicturesTest, WhatIsNotThereIsNamed) {
  AddQuery("nowhere");
  NIGHTMAP_EXPECT_ERROR(
      DataError,
      Read(),
      "nowhere: no such folder, list or picture: correct `pictures` in site.toml:10");
  std::filesystem::create_directories(Site() / "nowhere");
  NIGHTMAP_EXPECT_ERROR(DataError, Read(), "nowhere: no pictures: put some there");
}

TEST_F(PicturesTest, ThePicturesOfAQueryHaveTimesOfTheirOwn) {
  folder_.Write("data/site/list.txt", "b.jpg\na.jpg\n");
  folder_.Write("data/site/c.jpg", "x");
  folder_.Write("data/site/truth.txt", "1 5 6 7 0 0 0 1\n");
  AddQuery("c.jpg");
  AddQuery("list.txt").ground_truth = "truth.txt";
  const auto sequences = Read();
  EXPECT_EQ(sequences[0].frames[0].time_ns, 4'000'000'000 * kSecond_ns);
  EXPECT_EQ(sequences[1].frames[0].time_ns, 4'001'000'000 * kSecond_ns);
  EXPECT_EQ(sequences[1].frames[1].time_ns, 4'001'000'001 * kSecond_ns);
  // The truth counts the pictures of its query, here the second one.
  const QueryLists lists = RunQueries({}, {}, sequences, 0);
  ASSERT_EQ(lists.ground_truth.size(), 1u);
  EXPECT_EQ(lists.ground_truth[0].time_ns, lists.queries[2].time_ns);
  EXPECT_EQ(lists.queries[2].color.path, "site/a.jpg");
  EXPECT_EQ(lists.ground_truth[0].pose.translation.x(), 5);
}

TEST_F(PicturesTest, APictureIsAQueryOnce) {
  folder_.Write("data/site/lobby/a.jpg", "x");
  AddQuery("lobby");
  AddQuery("lobby/a.jpg");
  NIGHTMAP_EXPECT_ERROR(
      DataError, Read(), "site.toml:20: site/lobby/a.jpg is a query already, of site.toml:10");
}

TEST_F(PicturesTest, CamerasAreOfTheFocalLengthInExif) {
  WritePicture(Site() / "a.jpg", 60, 40, {{"Exif:FocalLengthIn35mmFilm", 36}});
  WritePicture(Site() / "b.jpg", 30, 20, {{"Exif:FocalLengthIn35mmFilm", 36}});
  WritePicture(Site() / "c.jpg", 60, 40, {{"Exif:FocalLengthIn35mmFilm", 36}});
  WritePicture(Site() / "d.jpg",
               60,
               40,
               {{"Exif:FocalLength", 5},
                {"Exif:FocalPlaneXResolution", 254},
                {"Exif:FocalPlaneResolutionUnit", 2},
                {"Exif:PixelXDimension", 120},
                {"Exif:PixelYDimension", 80}});
  AddQuery(".");
  const auto cameras = Cameras();
  ASSERT_EQ(cameras.size(), 4u);
  const Camera expected{.width = 60, .height = 40, .fx = 60, .fy = 60, .cx = 29.5, .cy = 19.5};
  EXPECT_EQ(cameras[0].width, 60);
  EXPECT_NEAR(cameras[0].fx, expected.fx, 1e-4);
  EXPECT_EQ(cameras[0].fy, cameras[0].fx);
  EXPECT_EQ(cameras[0].cx, expected.cx);
  EXPECT_EQ(cameras[0].cy, expected.cy);
  EXPECT_NEAR(cameras[1].fx, 30, 1e-4);
  EXPECT_EQ(cameras[2], cameras[0]);
  EXPECT_NEAR(cameras[3].fx, 25, 1e-4);  // 50 px at the size it was taken with
  EXPECT_EQ(cameras_.size(), 4u);        // of the site, and three that differ
  EXPECT_EQ(sequences_[0].frames[2].camera_idx, 1);
  for (const RawFrame& frame : Inspect()) EXPECT_EQ(frame.problem, "");
}

TEST_F(PicturesTest, PixelsAreAsStoredWhateverTheOrientation) {
  for (const int orientation : {1, 6}) {
    const auto path = Site() / fmt::format("{}.jpg", orientation);
    WritePicture(path, 60, 40, {{"Exif:FocalLengthIn35mmFilm", 36}, {"Orientation", orientation}});
    EXPECT_EQ(ReadColorImage(path).width, 60);
    EXPECT_EQ(InspectImage(path).height, 40);
  }
  AddQuery(".");
  const auto cameras = Cameras();
  EXPECT_EQ(cameras[1], cameras[0]);
}

TEST_F(PicturesTest, GrayPicturesAreReadAsColor) {
  WritePicture(Site() / "gray.jpg", 60, 40, {{"Exif:FocalLengthIn35mmFilm", 36}}, 1);
  AddQuery("gray.jpg");
  EXPECT_NEAR(Cameras().at(0).fx, 60, 1e-4);
  EXPECT_EQ(Inspect().at(0).problem, "");
  EXPECT_EQ(ReadColorImage(Site() / "gray.jpg").num_channels, 3);
}

TEST_F(PicturesTest, TheFieldOfViewIsOfPicturesThatDoNotSay) {
  WritePicture(Site() / "a.png", 60, 40);
  WritePicture(Site() / "b.jpg", 60, 40, {{"Exif:FocalLengthIn35mmFilm", 36}});
  AddQuery(".").horizontal_fov_deg = 90;
  const auto cameras = Cameras();
  EXPECT_NEAR(cameras[0].fx, 30, 1e-9);
  EXPECT_NEAR(cameras[1].fx, 60, 1e-4);
}

TEST_F(PicturesTest, CamerasCsvComesFirst) {
  WritePicture(Site() / "lobby/a.jpg", 60, 40, {{"Exif:FocalLengthIn35mmFilm", 36}});
  WritePicture(Site() / "lobby/b.jpg", 60, 40, {{"Exif:FocalLengthIn35mmFilm", 36}});
  folder_.Write("data/site/lobby/cameras.csv",
                std::string(kCsvHeader) + "a.jpg,60,40,70,71,28,18,0.1,0.2,0.3,0.4,0.5\n");
  const Camera expected{.width = 60,
                        .height = 40,
                        .fx = 70,
                        .fy = 71,
                        .cx = 28,
                        .cy = 18,
                        .k1 = 0.1,
                        .k2 = 0.2,
                        .p1 = 0.3,
                        .p2 = 0.4,
                        .k3 = 0.5};
  AddQuery("lobby");
  EXPECT_EQ(Cameras()[0], expected);
  EXPECT_NEAR(Cameras()[1].fx, 60, 1e-4);
  site_.queries[0].pictures = "lobby/a.jpg";
  EXPECT_EQ(Cameras()[0], expected);
}

TEST_F(PicturesTest, MistakesInCamerasCsvAreNamedWithTheirLine) {
  WritePicture(Site() / "a.jpg", 60, 40);
  AddQuery("a.jpg");
  const auto expect = [&](const std::string& text, const std::string& why) {
    folder_.Write("data/site/cameras.csv", text);
    NIGHTMAP_EXPECT_ERROR(DataError, Cameras(), "cameras.csv:");
    NIGHTMAP_EXPECT_ERROR(DataError, Cameras(), why);
  };
  const std::string row = "a.jpg,60,40,70,70,28,18,0,0,0,0,0\n";
  expect("picture,fx\n", "1: the header must be");
  expect(kCsvHeader + row + row, "3: a second camera of a.jpg");
  expect(std::string(kCsvHeader) + "a.jpg,60,40,0,70,28,18,0,0,0,0,0\n", "2: fx and fy");
  expect(std::string(kCsvHeader) + "a.jpg,60,40,nan,70,28,18,0,0,0,0,0\n", "2: fx is 'nan'");
  expect(std::string(kCsvHeader) + "a.jpg,0,40,70,70,28,18,0,0,0,0,0\n", "2: width is 0");
  expect(std::string(kCsvHeader) + "a.jpg,60,40\n", "2: 3 fields, expected 12");
}

TEST_F(PicturesTest, APictureOfUnknownLensHasTheUsualOne) {
  AddQuery("a.jpg");
  options_.unknown_fov_deg = 90;
  // A program that does not know it may write 0.
  using Attributes = std::map<std::string, float>;
  for (const Attributes& useless : {Attributes{},
                                    Attributes{{"Exif:FocalLengthIn35mmFilm", 0}},
                                    Attributes{{"Exif:FocalLength", 0}},
                                    Attributes{{"Exif:FocalLength", 5}},
                                    Attributes{{"Exif:FocalLength", 5},
                                               {"Exif:FocalPlaneXResolution", 0},
                                               {"Exif:FocalPlaneResolutionUnit", 2}}}) {
    WritePicture(Site() / "a.jpg", 40, 60, useless);
    EXPECT_NEAR(Cameras().at(0).fx, 30, 1e-9);  // of the longer side
    EXPECT_EQ(cameras_.back().focal_sigma_ratio, options_.unknown_focal_sigma_ratio);
  }
  site_.queries[0].camera_idx = 0;
  EXPECT_EQ(Cameras()[0], site_.cameras[0].color);
  EXPECT_TRUE(cameras_.back().IsCalibrated());
}

TEST_F(PicturesTest, TheLessIsKnownOfALensTheLessSureIsItsFocalLength) {
  WritePicture(Site() / "exif.jpg", 60, 40, {{"Exif:FocalLengthIn35mmFilm", 36}});
  WritePicture(Site() / "plain.jpg", 60, 40);
  WritePicture(Site() / "listed.jpg", 60, 40);
  folder_.Write("data/site/cameras.csv",
                std::string(kCsvHeader) + "listed.jpg,60,40,70,70,28,18,0,0,0,0,0\n");
  AddQuery(".").horizontal_fov_deg = 90;
  Cameras();
  std::map<std::string, double> sigma_ratios;
  for (const RgbdCamera& camera : cameras_)
    sigma_ratios[camera.camera_id] = camera.focal_sigma_ratio;
  EXPECT_EQ(sigma_ratios.at("site/listed.jpg"), 0);
  EXPECT_EQ(sigma_ratios.at("site/exif.jpg"), options_.exif_focal_sigma_ratio);
  EXPECT_EQ(sigma_ratios.at("site/plain.jpg"), options_.fov_focal_sigma_ratio);
}

TEST_F(PicturesTest, WhatCannotBeReadStaysAQueryWithItsProblem) {
  WritePicture(Site() / "whole.jpg", 60, 40, {{"Exif:FocalLengthIn35mmFilm", 36}});
  const std::string bytes = ReadBytes(Site() / "whole.jpg");
  folder_.Write("data/site/cut.jpg", bytes.substr(0, bytes.size() - 20));
  folder_.Write("data/site/text.jpg", "hello");
  folder_.Write("data/site/list.txt", "whole.jpg\ncut.jpg\ntext.jpg\nmissing.jpg\n");
  AddQuery("list.txt");
  const auto frames = Inspect();
  EXPECT_EQ(frames[0].problem, "");
  EXPECT_THAT(frames[1].problem, testing::HasSubstr("site/cut.jpg: truncated"));
  EXPECT_THAT(frames[2].problem, testing::StartsWith("site/text.jpg"));
  EXPECT_EQ(frames[3].problem, "site/missing.jpg: no such image file");
  const QueryLists lists = RunQueries({}, {}, sequences_, 0);
  EXPECT_EQ(lists.queries.size(), 4u);
  EXPECT_EQ(lists.skipped.size(), 3u);
}

TEST_F(PicturesTest, APictureThatIsTooLargeIsAProblemBeforeItIsDecoded) {
  WritePicture(Site() / "a.png", 600, 400);
  AddQuery("a.png").horizontal_fov_deg = 60;
  options_.max_picture_mpx = 0.24;
  EXPECT_EQ(Inspect()[0].problem, "");
  EXPECT_EQ(cameras_.at(static_cast<std::size_t>(sequences_[0].frames[0].camera_idx)).color.width,
            600);
  options_.max_picture_mpx = 0.23;
  EXPECT_EQ(
      Inspect()[0].problem,
      "site/a.png: 600 x 400 pixels are more than max_picture_mpx = 0.23: make it smaller, or "
      "raise max_picture_mpx of queries");
  // Its camera has another size, so localize does not decode it either.
  const QueryLists lists = RunQueries({}, {}, sequences_, 0);
  NIGHTMAP_EXPECT_ERROR(DataError,
                        LoadColor(lists.queries[0], cameras_[0], Data()),
                        "site/a.png: 600 x 400 pixels, its camera has 32 x 24");
}

TEST_F(PicturesTest, ACameraThatIsTooLargeIsRefused) {
  WritePicture(Site() / "a.png", 60, 40);
  AddQuery("a.png");
  folder_.Write("data/site/cameras.csv",
                std::string(kCsvHeader) + "a.png,30000,30000,70,70,28,18,0,0,0,0,0\n");
  NIGHTMAP_EXPECT_ERROR(
      DataError, Cameras(), "camera of site/a.png: 30000 x 30000 pixels are more");
  site_.queries.clear();
  site_.cameras[0].depth = {.width = 20000, .height = 20000};
  NIGHTMAP_EXPECT_ERROR(DataError, Cameras(), "camera of map: 20000 x 20000 pixels are more");
}

TEST_F(PicturesTest, NamesThatAreNotTextStayQueriesWithTheirProblem) {
  WritePicture(Site() / "lobby/good.png", 60, 40);
  for (const char* name : {"\xff.png", "a\nb.png"}) {
    std::filesystem::copy_file(Site() / "lobby/good.png", Site() / "lobby" / name);
  }
  AddQuery("lobby").horizontal_fov_deg = 60;
  Inspect();
  const QueryLists lists = RunQueries({}, {}, sequences_, 0);
  const auto read = ReadFrames(folder_.Write("queries.csv", FramesToCsv(lists.queries)));
  ASSERT_EQ(read.size(), 3u);
  EXPECT_EQ(read[0].color.path, "site/lobby/a\\x0ab.png");
  EXPECT_EQ(read[1].color.path, "site/lobby/good.png");
  EXPECT_EQ(read[2].color.path, "site/lobby/\\xff.png");
  ASSERT_EQ(lists.skipped.size(), 2u);
  EXPECT_THAT(lists.skipped[0], testing::HasSubstr("the name is not UTF-8 or holds control"));
}

TEST_F(PicturesTest, APictureOfAnotherSizeThanItsCameraIsAProblem) {
  WritePicture(Site() / "a.jpg", 64, 48);
  AddQuery("a.jpg", 0);
  EXPECT_THAT(
      Inspect()[0].problem,
      testing::HasSubstr("64 x 48 pixels, its camera has 32 x 24: pictures of another size"));
}

}  // namespace nightmap::pictures_test
