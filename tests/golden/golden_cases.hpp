// The streams that the golden vectors hold: one for each thing that the wire format can say. Inputs
// are integers that lie beside this file or follow from integer code, never a simulator's doubles.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/base/status.hpp"
#include "core/cloud/sensor_frame.hpp"
#include "core/model/stream_config.hpp"
#include "core/pipeline/stream_tables.hpp"

namespace planecast::test {

/// One stream. Its frames: depth images, or clouds for raw-cloud streams.
struct GoldenCase {
  std::string name;  ///< its file is name.plc
  StreamConfig config;
  std::size_t slice_bytes = 0;
  std::vector<std::vector<std::uint16_t>> depth;
  std::vector<std::vector<Point3f>> clouds;
  bool surfaces = true;  ///< whether the encoder looks for surfaces
  bool drop_outliers = false;
  bool no_time = false;  ///< every tile is coded by runs
  bool dump = false;     ///< small enough to list point by point in name.txt
};

/// The frame that a decoder of the case needs memory for.
FrameLimits limits_of(const GoldenCase& c);

/// All cases. `folder` holds inputs/*.u16; an error names the one that cannot be read.
Result<std::vector<GoldenCase>> golden_cases(const std::filesystem::path& folder);

/// Renders inputs/*.u16 with the simulator. Only for a new set of inputs: they never change.
Result<Done> render_inputs(const std::filesystem::path& folder);

}  // namespace planecast::test
