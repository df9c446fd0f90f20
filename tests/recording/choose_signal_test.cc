// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/choose_signal.h"

#include "pipeline/base/input_error.h"
#include "tests/test_data.h"

namespace nightmap::choose_signal_test {

Signal Scanner(const std::string& id, std::size_t num_scans = 1) {
  Signal signal{SignalKind::kScan, id, {}, {}};
  signal.samples.resize(num_scans);
  return signal;
}

std::string Chosen(const std::vector<Signal>& scans, const std::string& id) {
  return ChooseScanner(scans, id, "stage.scan_sensor").sensor_id;
}

TEST(ChooseScanner, TheOnlyOneNeedsNoName) {
  EXPECT_EQ(Chosen({Scanner("front")}, ""), "front");
  EXPECT_EQ(Chosen({Scanner("front")}, "front"), "front");
}

TEST(ChooseScanner, OfSeveralTheNamedOneWhateverTheOthers) {
  const std::vector<Signal> scans{Scanner("front"), Scanner("rear"), Scanner("dead", 0)};
  EXPECT_EQ(&ChooseScanner(scans, "rear", "stage.scan_sensor"), &scans[1]);
  EXPECT_EQ(&ChooseScanner(scans, "front", "stage.scan_sensor"), &scans[0]);
}

TEST(ChooseScanner, AnIdThatNamesNoneIsToldWithThoseThatDo) {
  const std::vector<Signal> scans{Scanner("front"), Scanner("rear")};
  NIGHTMAP_EXPECT_ERROR(
      UsageError,
      Chosen(scans, ""),
      "stage.scan_sensor is '': choose one of the sensors that scan: front, rear");
  NIGHTMAP_EXPECT_ERROR(
      UsageError, Chosen(scans, "Front"), "is 'Front': choose one of the sensors");
  NIGHTMAP_EXPECT_ERROR(UsageError, Chosen({Scanner("front")}, "rear"), "is 'rear': choose one");
}

void ExpectRemedyInText(const std::vector<Signal>& scans,
                        const std::string& id,
                        const std::string& text) {
  try {
    Chosen(scans, id);
    ADD_FAILURE() << "no error";
  } catch (const InputError& error) {
    EXPECT_EQ(error.WhichRemedy(), InputError::Remedy::kInText);
    ASSERT_EQ(error.Inputs().size(), 1U);
    EXPECT_EQ(error.Inputs()[0].port, "scans");
    EXPECT_THAT(error.Text(), testing::HasSubstr(text));
  }
}

TEST(ChooseScanner, ASiteThatDoesNotScanIsToldWhatItsConfigLacks) {
  for (const std::string id : {"", "front"}) {
    ExpectRemedyInText({}, id, "no sensor of the site scans; add a [[sensor]] of kind \"scan\"");
    ExpectRemedyInText({Scanner("front", 0)},
                       id,
                       "sensor 'front' has no scan; add its [[signal]] to the site config");
  }
  ExpectRemedyInText({Scanner("front"), Scanner("rear", 0)}, "rear", "sensor 'rear' has no scan");
}

}  // namespace nightmap::choose_signal_test
