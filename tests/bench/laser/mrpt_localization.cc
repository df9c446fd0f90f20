// SPDX-License-Identifier: Apache-2.0
// mrpt_localization: locates scans with the particle filter of MRPT; mrpt_localization.py compiles
// and calls it.
//
// Usage: mrpt_localization NAME=VALUE... < input
// The names are those of Settings. The input is text:
//   grid COLUMNS ROWS RESOLUTION_M    then a row per line, the lowest first: 0 unknown, 1 free,
//                                     2 occupied; the corner of the first cell is at (0, 0)
//   query SCANS X_M Y_M RADIUS_M      where the robot may be; radius 0: anywhere
//   scan HEADING_RAD X_M Y_M FIRST_ANGLE_RAD STEP_RAD LIMIT_M BEAMS RANGE_M...     SCANS times
// Each query and seed gives a line: query, seed, x (m), y (m), heading (rad), variances of the
// three, particles at the end, CPU seconds. The particles of a run depend on its seed only.
#include <mrpt/bayes/CParticleFilter.h>
#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/random/RandomGenerators.h>
#include <mrpt/slam/CMonteCarloLocalization2D.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <ctime>
#include <iostream>
#include <map>
#include <stdexcept>
#include <string>

namespace {

using mrpt::maps::COccupancyGridMap2D;

constexpr double kPi = 3.14159265358979323846;

using Settings = std::map<std::string, double>;

struct Query {
  mrpt::obs::CSensoryFrame scans;
  double x_m = 0;
  double y_m = 0;
  double radius_m = 0;
};

Settings ReadSettings(int argc, char** argv) {
  Settings settings;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const auto equals = word.find('=');
    if (equals == std::string::npos) throw std::runtime_error(word + ": not NAME=VALUE");
    settings[word.substr(0, equals)] = std::stod(word.substr(equals + 1));
  }
  return settings;
}

COccupancyGridMap2D::Ptr ReadGrid(const Settings& settings) {
  std::string word;
  int columns = 0;
  int rows = 0;
  float resolution_m = 0;
  if (!(std::cin >> word >> columns >> rows >> resolution_m) || word != "grid") {
    throw std::runtime_error("the input does not begin with a grid");
  }
  auto grid = COccupancyGridMap2D::Create();
  const auto cells = [&](int n) { return static_cast<float>(n) * resolution_m; };
  grid->setSize(0, cells(columns), 0, cells(rows), resolution_m);
  for (int row = 0; row < rows; ++row) {
    std::cin >> word;
    if (static_cast<int>(word.size()) != columns) throw std::runtime_error("a short row");
    for (int column = 0; column < columns; ++column) {
      constexpr float kFree[] = {0.5F, 0.95F, 0.05F};
      grid->setCell(column, row, kFree[word[static_cast<std::size_t>(column)] - '0']);
    }
  }
  auto& options = grid->likelihoodOptions;
  options.likelihoodMethod =
      static_cast<COccupancyGridMap2D::TLikelihoodMethod>(settings.at("likelihoodMethod"));
  options.LF_stdHit = static_cast<float>(settings.at("LF_stdHit"));
  options.LF_maxCorrsDistance = static_cast<float>(settings.at("LF_maxCorrsDistance"));
  options.LF_zHit = static_cast<float>(settings.at("LF_zHit"));
  options.LF_zRandom = static_cast<float>(settings.at("LF_zRandom"));
  options.LF_maxRange = static_cast<float>(settings.at("LF_maxRange"));
  options.LF_decimation = static_cast<std::uint32_t>(settings.at("LF_decimation"));
  options.LF_alternateAverageMethod = settings.at("LF_alternateAverageMethod") > 0;
  options.consensus_takeEachRange = static_cast<int>(settings.at("consensus_takeEachRange"));
  options.consensus_pow = static_cast<float>(settings.at("consensus_pow"));
  options.rayTracing_decimation = static_cast<int>(settings.at("rayTracing_decimation"));
  options.rayTracing_stdHit = static_cast<float>(settings.at("rayTracing_stdHit"));
  return grid;
}

mrpt::obs::CObservation2DRangeScan::Ptr ReadScan() {
  std::string word;
  double heading_rad = 0, x_m = 0, y_m = 0, first_rad = 0, step_rad = 0, limit_m = 0;
  std::size_t num_beams = 0;
  std::cin >> word >> heading_rad >> x_m >> y_m >> first_rad >> step_rad >> limit_m >> num_beams;
  if (!std::cin || word != "scan") throw std::runtime_error("a damaged scan");
  auto scan = mrpt::obs::CObservation2DRangeScan::Create();
  // MRPT's beams are symmetric about the sensor's x.
  const double aperture_rad = step_rad * (static_cast<double>(num_beams) - 1);
  scan->aperture = static_cast<float>(std::abs(aperture_rad));
  scan->rightToLeft = step_rad > 0;
  scan->sensorPose =
      mrpt::poses::CPose3D(x_m, y_m, 0, heading_rad + first_rad + aperture_rad / 2, 0, 0);
  scan->maxRange = static_cast<float>(limit_m);
  scan->resizeScan(num_beams);
  for (std::size_t i = 0; i < num_beams; ++i) {
    float range_m = 0;
    std::cin >> range_m;
    const bool is_hit = range_m > 0 && range_m < limit_m;
    scan->setScanRange(i, range_m);
    scan->setScanRangeValidity(i, is_hit);
  }
  return scan;
}

bool ReadQuery(Query& query) {
  std::string word;
  int num_scans = 0;
  if (!(std::cin >> word)) return false;
  if (!(std::cin >> num_scans >> query.x_m >> query.y_m >> query.radius_m) || word != "query") {
    throw std::runtime_error("a damaged query");
  }
  for (int i = 0; i < num_scans; ++i) query.scans.insert(ReadScan());
  if (!std::cin) throw std::runtime_error("a truncated query");
  return true;
}

// Particles on free cells: of the disc, or everywhere.
void Spread(const Query& query,
            COccupancyGridMap2D& grid,
            int num_particles,
            mrpt::slam::CMonteCarloLocalization2D& pdf) {
  constexpr double kFree = 0.7;
  const double r = query.radius_m;
  if (r <= 0) return pdf.resetUniformFreeSpace(&grid, kFree, num_particles);
  const int in_square = static_cast<int>(num_particles * 4 / kPi);
  pdf.resetUniformFreeSpace(
      &grid, kFree, in_square, query.x_m - r, query.x_m + r, query.y_m - r, query.y_m + r);
  auto& all = pdf.m_particles;
  all.erase(std::remove_if(all.begin(),
                           all.end(),
                           [&](const auto& particle) {
                             return std::hypot(particle.d.x - query.x_m, particle.d.y - query.y_m) >
                                    r;
                           }),
            all.end());
  if (all.empty()) throw std::runtime_error("no free cell in the disc");
}

// The robot stands still: only noise moves the particles. It shrinks from step to step.
mrpt::obs::CActionCollection Stand(const Settings& settings, double progress) {
  const auto between = [&](const std::string& name) {
    const double first = settings.at("first_" + name);
    return first * std::pow(settings.at("last_" + name) / first, progress);
  };
  mrpt::obs::CActionRobotMovement2D::TMotionModelOptions model;
  model.modelSelection = mrpt::obs::CActionRobotMovement2D::mmGaussian;
  model.gaussianModel.minStdXY = between("noise_m");
  model.gaussianModel.minStdPHI = between("noise_deg") * kPi / 180;
  mrpt::obs::CActionRobotMovement2D motion;
  motion.computeFromOdometry(mrpt::poses::CPose2D(), model);
  mrpt::obs::CActionCollection actions;
  actions.insert(motion);
  return actions;
}

mrpt::bayes::CParticleFilter MakeFilter(const Settings& settings) {
  using mrpt::bayes::CParticleFilter;
  CParticleFilter filter;
  auto& options = filter.m_options;
  options.PF_algorithm =
      static_cast<CParticleFilter::TParticleFilterAlgorithm>(settings.at("PF_algorithm"));
  options.resamplingMethod =
      static_cast<CParticleFilter::TParticleResamplingAlgorithm>(settings.at("resamplingMethod"));
  options.adaptiveSampleSize = settings.at("adaptiveSampleSize") > 0;
  options.BETA = settings.at("BETA");
  options.powFactor = settings.at("powFactor");
  options.pfAuxFilterOptimal_MaximumSearchSamples =
      static_cast<unsigned>(settings.at("pfAuxFilterOptimal_MaximumSearchSamples"));
  return filter;
}

void Locate(const Settings& settings,
            const Query& query,
            const COccupancyGridMap2D::Ptr& grid,
            mrpt::slam::CMonteCarloLocalization2D& pdf) {
  pdf.options.metricMap = grid;
  auto& kld = pdf.options.KLD_params;
  kld.KLD_binSize_XY = settings.at("KLD_binSize_XY");
  kld.KLD_binSize_PHI = settings.at("KLD_binSize_PHI_deg") * kPi / 180;
  kld.KLD_delta = settings.at("KLD_delta");
  kld.KLD_epsilon = settings.at("KLD_epsilon");
  kld.KLD_minSampleSize = static_cast<unsigned>(settings.at("KLD_minSampleSize"));
  kld.KLD_maxSampleSize = static_cast<unsigned>(settings.at("KLD_maxSampleSize"));
  const auto filter = MakeFilter(settings);
  Spread(query, *grid, static_cast<int>(settings.at("particles_count")), pdf);
  const int num_steps = static_cast<int>(settings.at("steps"));
  for (int step = 0; step < num_steps; ++step) {
    const auto actions = Stand(settings, step / std::max(1.0, num_steps - 1.0));
    filter.executeOn(pdf, &actions, &query.scans);
  }
}

void Print(int query_idx,
           unsigned seed,
           const Settings& settings,
           const Query& query,
           const COccupancyGridMap2D::Ptr& grid) {
  mrpt::random::getRandomGenerator().randomize(seed);
  mrpt::slam::CMonteCarloLocalization2D pdf;
  const std::clock_t start = std::clock();
  try {
    Locate(settings, query, grid, pdf);
  } catch (const std::exception& error) {
    std::cerr << "query " << query_idx << ": not located: " << error.what() << "\n";
    return;
  }
  const auto [covariance, mean] = pdf.getCovarianceAndMean();
  const double cpu_s = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  std::cout << query_idx << ' ' << seed << ' ' << mean.x() << ' ' << mean.y() << ' ' << mean.phi();
  for (int i = 0; i < 3; ++i) std::cout << ' ' << covariance(i, i);
  std::cout << ' ' << pdf.size() << ' ' << cpu_s << std::endl;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    std::ios::sync_with_stdio(false);
    std::cout.precision(9);
    const Settings settings = ReadSettings(argc, argv);
    const auto grid = ReadGrid(settings);
    int query_idx = 0;
    for (Query query; ReadQuery(query); query = Query(), ++query_idx) {
      for (unsigned seed = 1; seed <= settings.at("seeds"); ++seed) {
        Print(query_idx, seed, settings, query, grid);
      }
    }
  } catch (const std::exception& error) {
    std::cerr << "error: " << error.what() << "\n";
    return 1;
  }
  return 0;
}
