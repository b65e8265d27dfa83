// Writes the golden vectors: make_golden FOLDER [--render-inputs]. The folder's inputs stay as they
// are unless asked for; everything else is written anew. --constants prints those that the second
// decoder needs.
#include <cstdio>
#include <filesystem>
#include <string>

#include "core/wire/mix_models.hpp"
#include "core/wire/residual_models.hpp"
#include "core/wire/tile_models.hpp"
#include "tests/golden/bad_packets.hpp"
#include "tests/golden/golden_vectors.hpp"

namespace planecast::test {
namespace {

namespace fs = std::filesystem;

Result<Done> write_vectors(const fs::path& folder, const std::vector<GoldenCase>& cases) {
  std::string expected = "# case frame slices readings crc32c(counts) crc32c(cloud)\n";
  for (const GoldenCase& c : cases) {
    const auto file = encode_golden(c);
    if (!file.ok()) return file.error();
    const auto frames = decode_golden(*file);
    if (!frames.ok()) return frames.error();
    expected += expected_lines(c.name, *frames);
    if (auto done = write_golden_file(folder / (c.name + ".plc"), *file); !done.ok()) return done;
    if (!c.dump) continue;
    const std::string dump = dump_lines(frames->front(), c.config.camera.width);
    if (auto done = write_golden_file(folder / (c.name + ".txt"), dump); !done.ok()) return done;
  }
  return write_golden_file(folder / "expected.txt", expected);
}

Result<Done> write_bad(const fs::path& folder) {
  const auto depth = read_golden_file(folder / "metres_160x120.plc");
  const auto raw = read_golden_file(folder / "raw_64x48.plc");
  const auto small = read_golden_file(folder / "lossless_1x1.plc");
  if (!depth.ok() || !raw.ok() || !small.ok())
    return Error{Status::kNotFound, "the vectors were not written"};
  const auto points = read_golden_file(folder / "points_metres.plc");
  const auto patches = read_golden_file(folder / "points_paper.plc");
  if (!points.ok() || !patches.ok())
    return Error{Status::kNotFound, "the vectors were not written"};
  const auto bad = bad_packets(BadBench(*depth, *raw, *points, *patches), *small);
  if (!bad.ok()) return bad.error();
  fs::remove_all(folder / "bad");
  fs::create_directory(folder / "bad");
  for (const BadPacket& packet : *bad) {
    auto done = write_golden_file(folder / "bad" / packet.file_name(), packet.bytes);
    if (!done.ok()) return done;
  }
  return Done{};
}

Result<Done> run(const fs::path& folder, bool render) {
  if (render) {
    fs::create_directories(folder / "inputs");
    if (auto done = render_inputs(folder); !done.ok()) return done;
  }
  const auto cases = golden_cases(folder);
  if (!cases.ok()) return cases.error();
  if (auto done = write_vectors(folder, *cases); !done.ok()) return done;
  return write_bad(folder);
}

void print_models(const char* kind, const char* name, const BitModel* models, std::size_t bytes) {
  for (std::size_t i = 0; i < bytes / sizeof(BitModel); ++i) {
    std::printf("%s %s %u %u %u\n", kind, name, models[i].fast(), models[i].slow(),
                unsigned{models[i].age()});
  }
}

void print_start_models(bool lossless) {
  const TileModels& m = trained_models(lossless);
  const auto print = [&](const char* name, const auto& models) {
    print_models(lossless ? "lossless" : "bounded", name,
                 reinterpret_cast<const BitModel*>(&models), sizeof models);
  };
  print("block_any", m.block_any);
  print("block_full", m.block_full);
  print("block_corrected", m.block_corrected);
  print("label_as_left", m.label_as_left);
  print("label_as_above", m.label_as_above);
  print("label_index", m.label_index);
  print("block_second", m.block_second);
  print("block_uniform", m.block_uniform);
  print("on_surface", m.on_surface);
  print("mask", m.mask);
  print("correction", m.correction);
  print("sign", m.sign);
  print("magnitude", m.magnitude);
  print("jump_length", m.jump_length);
  print("jump_top", m.jump_top);
  print("block_flat", m.block_flat);
  print("plane_length", m.plane_length);
  print("plane_sign", m.plane_sign);
  print("plane_top", m.plane_top);
}

void print_residual_models() {
  const auto print = [](const char* name, const SymbolModel& model) {
    std::printf("lossless %s", name);
    for (const std::int16_t bound : model.bounds) std::printf(" %d", int{bound});
    std::printf("\n");
  };
  for (const bool every_count : {false, true}) {
    static ResidualModels models;
    unpack_residuals(every_count, models);
    for (const SymbolModel& m : models.shape) print(every_count ? "shape1" : "shape0", m);
    for (const SymbolModel& m : models.errors) print(every_count ? "errors1" : "errors0", m);
  }
}

// Estimates and decisions seen of mixed models; weights of each mixer and how often it was used.
void print_mix_models(bool lossless) {
  const char* kind = lossless ? "lossless" : "bounded";
  const MixModels& m = trained_mix_models(lossless);
  const auto print = [&](const char* name, const MixedModel& model) {
    std::printf("%s %s %u %u %u\n", kind, name, unsigned{model.fast}, unsigned{model.slow},
                unsigned{model.seen});
  };
  const auto print_weights = [&](const char* name, const auto& weights) {
    std::printf("%s %s", kind, name);
    for (const std::int32_t w : weights.weight) std::printf(" %d", w);
    std::printf(" %u\n", unsigned{weights.uses});
  };
  for (const auto& context : m.pixel) {
    for (const MixedModel& model : context) print("mix_pixel", model);
  }
  for (const MixedModel& model : m.mask) print("mix_mask", model);
  for (const auto& set : m.pixel_mixers) {
    for (const auto& mixer : set) print_weights("mix_pixel_weights", mixer);
  }
  for (const auto& mixer : m.mask_mixers) print_weights("mix_mask_weights", mixer);
  print_models(kind, "mix_low", m.low[0], sizeof m.low);
}

void print_tables() {
  for (const auto& row : detail::kActivity.of) {
    std::printf("table activity");
    for (const std::uint8_t activity : row) std::printf(" %u", unsigned{activity});
    std::printf("\n");
  }
  std::printf("table drift");
  for (const std::int32_t scale : detail::kDriftScale) std::printf(" %d", scale);
  std::printf("\n");
}

}  // namespace
}  // namespace planecast::test

int main(int argc, char** argv) {
  if (argc == 2 && std::string(argv[1]) == "--constants") {
    planecast::test::print_start_models(true);
    planecast::test::print_start_models(false);
    planecast::test::print_residual_models();
    planecast::test::print_mix_models(true);
    planecast::test::print_mix_models(false);
    planecast::test::print_tables();
    return 0;
  }
  const bool render = argc == 3 && std::string(argv[2]) == "--render-inputs";
  if (argc != 2 && !render) {
    std::fprintf(stderr, "usage: make_golden FOLDER [--render-inputs] | --constants\n");
    return 2;
  }
  const auto done = planecast::test::run(argv[1], render);
  if (done.ok()) return 0;
  std::fprintf(stderr, "make_golden: %s\n", done.error().message.c_str());
  return 1;
}
