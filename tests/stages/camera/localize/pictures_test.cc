// SPDX-License-Identifier: Apache-2.0
// Whole pictures, from pixels to the verdict.
#include <cmath>
#include <functional>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "stages/camera/localize/describe_picture.h"
#include "stages/camera/localize/localize.h"
#include "tests/stages/camera/localize/rendered_map.h"
#include "tests/test_data.h"

namespace nightmap::pictures_test {

cv::Mat View(ColorImage& image) {
  return {image.height, image.width, CV_8UC3, image.pixels.data()};
}

ColorImage Blank(int width, int height) {
  ColorImage image{width, height, 3, {}};
  image.pixels.assign(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 128);
  return image;
}

// The camera of a picture of `times` as many pixels each way.
Camera Finer(const Camera& camera, int times) {
  return {camera.width * times,
          camera.height * times,
          camera.fx * times,
          camera.fy * times,
          (camera.cx + 0.5) * times - 0.5,
          (camera.cy + 0.5) * times - 0.5};
}

class PicturesTest : public testing::Test {
 protected:
  static const RenderedMap& Map() {
    static const RenderedMap map = MakeRenderedMap();
    return map;
  }

  QueryResult Localize(const ColorImage& picture, const Camera& camera) {
    return LocalizeLoaded(camera, [&] { return picture; });
  }
  QueryResult LocalizeLoaded(const Camera& camera, const std::function<ColorImage()>& load) {
    RgbdCamera of_query;
    of_query.color = camera;
    const MapInRegions map = InRegions(Map().map);
    const LocalizeInput input{{FrameRecord{3, 5, 0, 0, {"query.png", ""}, {}, {}}},
                              {of_query},
                              Map().extraction,
                              &map,
                              &Map().vocabulary,
                              [&](const FrameRecord&, const RgbdCamera&) { return load(); },
                              [&](const std::string& problem) { problems_.push_back(problem); },
                              [](const char*) {},
                              {Map().camera},
                              limits_};
    return RunLocalize(options_, input, NoProgress(), 1)[0];
  }
  QueryResult LocalizePlain() { return Localize(plain_, camera_); }

  void ExpectLocated(const QueryResult& result, const Rigid3& pose) const {
    ASSERT_TRUE(result.IsLocated()) << result.reason;
    EXPECT_LT((result.map_from_camera.translation - pose.translation).norm(), 0.03);
    EXPECT_LT(AngleBetween_rad(result.map_from_camera, pose), 0.01);
  }

  LocalizeOptions options_;
  MapLimits limits_;
  std::vector<std::string> problems_;
  const Camera camera_ = Map().camera.color;
  const Rigid3 pose_ = PosterPose(2.4);
  ColorImage plain_ = Map().Picture(camera_, pose_, 77);
};

TEST_F(PicturesTest, APictureLikeTheMapsIsLocated) {
  const QueryResult result = LocalizePlain();
  ExpectLocated(result, pose_);
  EXPECT_GT(result.num_inliers, 100);
}

// A map of more landmarks than are searched whole: with one region, its only part is all of it.
TEST_F(PicturesTest, APictureIsLocatedInTheOnlyPartAsInTheWholeMap) {
  const QueryResult whole = LocalizePlain();
  limits_.whole_landmarks = Map().map.NumLandmarks() - 1;
  const QueryResult in_part = LocalizePlain();
  EXPECT_EQ(QueriesToCsv({in_part}), QueriesToCsv({whole}));
  EXPECT_TRUE(
      Localize(ColorImage{320, 240, 3, std::vector<std::uint8_t>(320 * 240 * 3, 9)}, camera_)
          .verdict == QueryVerdict::kNoFeatures);
}

// Like a phone's picture: four times as fine, whether the detail is real or not.
TEST_F(PicturesTest, AFinerPictureIsLocatedAsWell) {
  const QueryResult plain = LocalizePlain();
  const Camera finer = Finer(camera_, 4);
  ColorImage enlarged = Blank(finer.width, finer.height);
  cv::Mat target = View(enlarged);
  cv::resize(View(plain_), target, target.size(), 0, 0, cv::INTER_CUBIC);
  for (const ColorImage& picture : {Map().Picture(finer, pose_, 78), enlarged}) {
    const QueryResult result = Localize(picture, finer);
    ExpectLocated(result, pose_);
    EXPECT_GT(result.num_inliers, 0.8 * plain.num_inliers);
    EXPECT_LT(result.reprojection_error_px, 1.5 * plain.reprojection_error_px);
  }
}

TEST_F(PicturesTest, OnlyMuchFinerPicturesAreScaled) {
  const Camera finer = Finer(camera_, 3);
  const ColorImage picture = Map().Picture(finer, pose_, 78);
  const QueryResult scaled = Localize(picture, finer);
  options_.max_focal_ratio = 3;
  const QueryResult whole = Localize(picture, finer);
  ExpectLocated(scaled, pose_);
  EXPECT_GT(whole.reprojection_error_px, 1.5 * scaled.reprojection_error_px);
  options_.max_focal_ratio = 2.9;
  EXPECT_EQ(Localize(picture, finer).reprojection_error_px, scaled.reprojection_error_px);
}

// A picture of a wide lens is no finer than the map's, and may still have many more pixels.
TEST_F(PicturesTest, APictureIsNotDescribedWithMorePixelsThanMapsAreMadeOf) {
  RgbdCamera wide;
  wide.color = {2400, 1800, camera_.fx, camera_.fx, 1199.5, 899.5};
  LocalizeInput input;
  input.cameras = {wide};
  input.map_cameras = {Map().camera};
  input.extraction = Map().extraction;
  input.extraction.num_features = 50;
  input.load_color = [](const FrameRecord&, const RgbdCamera& camera) {
    return Blank(camera.color.width, camera.color.height);
  };
  const DescribedPicture described = DescribePicture(options_, input, FrameRecord{});
  EXPECT_EQ(described.problem, "");
  EXPECT_NEAR(described.lens.camera.width * described.lens.camera.height, 1e6 * kWorking_mpx, 2000);
  EXPECT_NEAR(described.lens.camera.fx / described.lens.camera.width, camera_.fx / 2400, 1e-4);
  input.map_cameras[0].color.width = 2000;  // the map is made of larger pictures
  input.map_cameras[0].color.height = 1500;
  EXPECT_NEAR(DescribePicture(options_, input, FrameRecord{}).lens.camera.width, 2000, 2);
}

// Another size, field of view and shape, and a lens with distortion.
TEST_F(PicturesTest, APictureOfAnotherLensIsLocated) {
  const Camera lens{400, 220, 290, 280, 190, 115, -0.15, 0.03, 0.001, -0.001};
  const Camera pinhole{1200, 900, 600, 600, 599.5, 449.5};
  const ColorImage wide = Map().Picture(pinhole, pose_, 79);
  ColorImage bent = Blank(lens.width, lens.height);
  for (int y = 0; y < lens.height; ++y) {
    for (int x = 0; x < lens.width; ++x) {
      const auto pixel = pinhole.Project(lens.BackProject({x, y}, 1));
      ASSERT_TRUE(pixel && pinhole.Contains(*pixel));
      for (int c = 0; c < 3; ++c) {
        bent.At(x, y, c) = wide.At(static_cast<int>(std::lround(pixel->x())),
                                   static_cast<int>(std::lround(pixel->y())),
                                   c);
      }
    }
  }
  const QueryResult right = Localize(bent, lens);
  ExpectLocated(right, pose_);
  Camera straight = lens;
  straight.k1 = straight.k2 = straight.p1 = straight.p2 = 0;
  const QueryResult wrong = Localize(bent, straight);
  EXPECT_GT(wrong.reprojection_error_px, 1.3 * right.reprojection_error_px);
}

TEST_F(PicturesTest, AGrayPictureIsLocated) {
  ColorImage gray = plain_;
  for (std::size_t i = 0; i < gray.pixels.size(); i += 3) {
    const int sum = plain_.pixels[i] + plain_.pixels[i + 1] + plain_.pixels[i + 2];
    for (std::size_t c = 0; c < 3; ++c) gray.pixels[i + c] = static_cast<std::uint8_t>(sum / 3);
  }
  ExpectLocated(Localize(gray, camera_), pose_);
}

TEST_F(PicturesTest, APictureTurnedByAQuarterIsLocated) {
  ColorImage turned = Blank(camera_.height, camera_.width);
  cv::Mat target = View(turned);
  cv::rotate(View(plain_), target, cv::ROTATE_90_CLOCKWISE);
  const Camera camera{turned.width, turned.height, camera_.fy, camera_.fx, 119.5, 159.5};
  // Down becomes left.
  const Rigid3 roll{
      Eigen::Quaterniond(Eigen::AngleAxisd(-std::numbers::pi / 2, Eigen::Vector3d::UnitZ())),
      Eigen::Vector3d::Zero()};
  ExpectLocated(Localize(turned, camera), pose_ * roll);
}

// As a phone's front camera stores it.
TEST_F(PicturesTest, AMirroredPictureIsNotInTheMap) {
  ColorImage mirrored = Blank(camera_.width, camera_.height);
  cv::Mat target = View(mirrored);
  cv::flip(View(plain_), target, 1);
  const QueryResult result = Localize(mirrored, camera_);
  EXPECT_EQ(result.verdict, QueryVerdict::kNotInMap);
  EXPECT_EQ(result.reason, "mirrored");
}

TEST_F(PicturesTest, ABlurredPictureIsLocatedOrRefused) {
  const auto blur = [&](double sigma_px) {
    ColorImage blurred = plain_;
    cv::GaussianBlur(View(plain_), View(blurred), {}, sigma_px);
    return Localize(blurred, camera_);
  };
  ExpectLocated(blur(1.5), pose_);
  const QueryResult lost = blur(25);
  EXPECT_FALSE(lost.HasPose());
  EXPECT_FALSE(lost.reason.empty());
}

TEST_F(PicturesTest, OneColorHasNoFeatures) {
  const QueryResult result = Localize(Blank(camera_.width, camera_.height), camera_);
  EXPECT_EQ(result.verdict, QueryVerdict::kNoFeatures);
  const Camera finer = Finer(camera_, 4);
  EXPECT_EQ(Localize(Blank(finer.width, finer.height), finer).verdict, QueryVerdict::kNoFeatures);
}

TEST_F(PicturesTest, ABrokenFileIsUnreadable) {
  const TemporaryFolder folder;
  WritePng(folder / "whole.png", plain_);
  const std::string bytes = ReadBytes(folder / "whole.png");
  folder.Write("cut.png", bytes.substr(0, bytes.size() / 2));
  folder.Write("text.png", "no picture");
  const auto localize = [&](const std::string& name) {
    return LocalizeLoaded(camera_, [&] { return ReadColorImage(folder / name); });
  };
  ExpectLocated(localize("whole.png"), pose_);
  EXPECT_TRUE(problems_.empty());
  for (const char* name : {"cut.png", "text.png", "missing.png"}) {
    const QueryResult result = localize(name);
    EXPECT_EQ(result.verdict, QueryVerdict::kUnreadable) << name;
    EXPECT_EQ(result.reason, "unreadable_image");
    EXPECT_THAT(problems_.back(), testing::HasSubstr(name));
  }
}

}  // namespace nightmap::pictures_test
