// SPDX-License-Identifier: Apache-2.0

#include "pipeline/base/error.h"
#include "pipeline/recording/site_config.h"
#include "tests/test_data.h"

namespace nightmap::site_scan_queries_test {

const std::string kSite = R"(root = "lab"
[[sensor]]
id = "laser"
kind = "scan"
[[sensor]]
id = "wheels"
kind = "odometry"
[[signal]]
sensor = "laser"
format = "carmen"
file = "a.log.gz"
message = "FLASER"
)";

const std::string kQuery = "[[query]]\nscans = \"wake.log\"\n";

ScanQueryConfig Parsed(const std::string& keys, const std::string& site = kSite) {
  return ParseSiteConfig(site + kQuery + keys, "s.toml").scan_queries.at(0);
}

void ExpectRefused(const std::string& keys,
                   const std::string& why,
                   const std::string& site = kSite) {
  NIGHTMAP_EXPECT_ERROR(UsageError, Parsed(keys, site), why);
}

std::string Replaced(const std::string& from, const std::string& to) {
  std::string text = kSite;
  EXPECT_NE(text.find(from), std::string::npos) << from;
  return text.replace(text.find(from), from.size(), to);
}

TEST(SiteScanQueries, OfOneScannerOnlyTheLogIsNeeded) {
  const ScanQueryConfig query = Parsed("");
  EXPECT_EQ(query.scans, "wake.log");
  EXPECT_EQ(query.sensor_idx, 0);
  EXPECT_EQ(query.format, "carmen");
  EXPECT_EQ(query.message, "FLASER");
  EXPECT_FALSE(query.turn);
  EXPECT_TRUE(query.near_m.empty());
  EXPECT_EQ(query.source, "s.toml:13");
}

TEST(SiteScanQueries, ALogIsATableAsThatOfTheRecordingIs) {
  const std::string site = Replaced("format = \"carmen\"", "format = \"csv\"\ncolumns = \"t_ns\"");
  const std::string table = site.substr(0, site.find("message"));
  const ScanQueryConfig query = Parsed("", table);
  EXPECT_EQ(query.format, "csv");
  EXPECT_EQ(query.columns, "t_ns");
  EXPECT_EQ(query.time_unit, "ns");
  EXPECT_EQ(Parsed("format = \"csv\"\ncolumns = \"t\"\n").time_unit, "");
  ExpectRefused("format = \"csv\"\n", "'columns' is missing");
  ExpectRefused("columns = \"t\"\n", "'columns' needs format = \"csv\"");
}

TEST(SiteScanQueries, ALogMayLieOutsideOfTheDataFolderAndHaveAPosition) {
  const std::string text = "[[query]]\nscans = \"../../tmp/a.log\"\nturn = true\n";
  const auto site = ParseSiteConfig(kSite + text + "near_m = [1.5, -2]\n", "s.toml");
  const ScanQueryConfig& query = site.scan_queries.at(0);
  EXPECT_EQ(query.scans, "../../tmp/a.log");
  EXPECT_TRUE(query.turn);
  EXPECT_EQ(query.near_m, (std::vector<double>{1.5, -2}));
  EXPECT_EQ(query.near_radius_m, 5);
  EXPECT_EQ(Parsed("near_m = [0, 0]\nnear_radius_m = 2\n").near_radius_m, 2);
  EXPECT_TRUE(site.queries.empty());  // those are pictures
}

TEST(SiteScanQueries, ALogIsLikeThatOfTheRecordingUnlessItSaysOtherwise) {
  const std::string front = Replaced("FLASER\"\n", "RLASER\"\nrate_hz = 5\n");
  EXPECT_EQ(Parsed("", front).message, "RLASER");
  EXPECT_EQ(Parsed("", front).rate_hz, 5);
  EXPECT_EQ(Parsed("message = \"ROBOTLASER1\"\n", front).message, "ROBOTLASER1");
  EXPECT_EQ(Parsed("message = \"ROBOTLASER1\"\n", front).rate_hz, 0);
  const std::string text = Replaced("\"carmen\"\nfile = \"a.log.gz\"\nmessage = \"FLASER\"\n",
                                    "\"text\"\nfile = \"a.txt\"\n");
  EXPECT_EQ(Parsed("", text).format, "text");
  EXPECT_EQ(Parsed("format = \"carmen\"\n", text).message, "FLASER");
  EXPECT_EQ(Parsed("format = \"text\"\n").format, "text");
}

TEST(SiteScanQueries, MistakesAreNamedWithTheirLine) {
  ExpectRefused("near = [1, 2]\n", "s.toml:15: unknown key 'near'");
  ExpectRefused("layout = \"pictures\"\n", "s.toml:15: unknown key 'layout'");
  ExpectRefused("near_m = [1]\n", "s.toml:13: near_m has 1 numbers: give x and y");
  ExpectRefused("near_m = [nan, 1]\n", "s.toml:15: near_m");
  ExpectRefused("near_m = [1, 2]\nnear_radius_m = 0\n", "near_radius_m = 0 must be above 0");
  ExpectRefused("near_m = [1, 2]\nnear_radius_m = -1\n", "s.toml:16: near_radius_m = -1");
  ExpectRefused("near_radius_m = 2\n", "'near_radius_m' needs near_m");
  ExpectRefused("message = \"ODOM\"\n", "s.toml:15: message");
  ExpectRefused("format = \"text\"\nmessage = \"FLASER\"\n", "needs format = \"carmen\"");
  ExpectRefused("format = \"text\"\nturn = true\n", "s.toml:13: turn = true needs the robot's");
  ExpectRefused("message = \"RAWLASER1\"\nturn = true\n", "turn = true needs the robot's odometry");
  ExpectRefused(kQuery, "s.toml:15: s.toml:13 asks for wake.log already: name it once");
  ExpectRefused("[[query]]\nscans = \"/a.log\"\n", "scans = \"/a.log\" must be a path relative");
  ExpectRefused("[[query]]\nscans = \"\"\n", "scans = \"\" must be a path relative");
  ExpectRefused("[[query]]\nscans = \"a\\nb\"\n", "holds control characters: rename the file");
}

TEST(SiteScanQueries, TheScannerMustBeClear) {
  const std::string two = kSite + "[[sensor]]\nid = \"rear\"\nkind = \"scan\"\n";
  ExpectRefused("", "is none of the sensors that scan: choose one of laser, rear", two);
  ExpectRefused("sensor = \"wheels\"\n", "choose one of laser, rear", two);
  EXPECT_EQ(Parsed("sensor = \"rear\"\n", two).sensor_idx, 2);
  EXPECT_EQ(Parsed("sensor = \"rear\"\n", two).message, "FLASER");
  const std::string none =
      "[[sensor]]\nid = \"wheels\"\nkind = \"odometry\"\n[[signal]]\nsensor = \"wheels\"\n"
      "format = \"carmen\"\nfile = \"a\"\nmessage = \"ODOM\"\n";
  ExpectRefused("", "s.toml:9: no sensor of the site scans: give the site config a", none);
}

TEST(SiteScanQueries, ThoseOfMakeComeAfterThoseOfTheSite) {
  SiteConfig site = ParseSiteConfig(kSite + kQuery, "s.toml");
  ParseAskedQueries("[[query]]\nscans = \"../b.log\"\nnear_m = [1.0, 2.0]\n", &site);
  ASSERT_EQ(site.scan_queries.size(), 2u);
  EXPECT_EQ(site.scan_queries[1].scans, "../b.log");
  EXPECT_EQ(site.scan_queries[1].source, "QUERY of make");
  NIGHTMAP_EXPECT_ERROR(UsageError,
                        ParseAskedQueries(kQuery, &site),
                        "QUERY of make: s.toml:13 asks for wake.log already");
}

}  // namespace nightmap::site_scan_queries_test
