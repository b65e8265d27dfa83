// Packs the trained starts of models for the program to hold:
//   pack_starts core/wire
// writes core/wire/*_packed.inc from the tables of core/wire/*_trained.inc that it was compiled
// with; to be run after training. A test holds the unpacked starts against the tables.
#include <cstdio>
#include <string>
#include <vector>

#include "core/wire/start_code.hpp"
#include "core/wire/start_writer.hpp"
#include "core/wire/trained_tables.hpp"

namespace {

using namespace planecast;
using namespace planecast::trained;

// Codes with `code` and writes the bytes to core/wire/NAME_packed.inc.
template <class Code>
bool pack(const std::string& folder, const char* name, Code code) {
  StartWriter writer;
  code(writer);
  const std::vector<std::uint8_t> bytes = writer.finish();
  std::FILE* out = std::fopen((folder + "/" + name + "_packed.inc").c_str(), "w");
  if (out == nullptr) return false;
  for (std::size_t i = 0; i < bytes.size(); ++i)
    std::fprintf(out, "%s%u,", i == 0 ? "" : (i % 25 == 0 ? "\n" : " "), unsigned{bytes[i]});
  std::fprintf(out, "\n");
  std::printf("%s: %zu bytes\n", name, bytes.size());
  return std::fclose(out) == 0;
}

bool same(const SymbolModel& a, const SymbolModel& b) {
  return std::equal(a.bounds, a.bounds + 16, b.bounds);
}

// How a start is packed: by counts where any give its bounds.
ResidualStart start_of(const SymbolModel& model) {
  ResidualStart out;
  while (ResidualStart::kAges[out.age_class] != model.bounds[0]) ++out.age_class;
  std::uint32_t shares[16];  // those below a symbol
  for (std::uint32_t s = 0; s < 16; ++s)
    shares[s] = s == 0 ? 0 : static_cast<std::uint32_t>(model.bounds[s]) - 8 * s;
  for (out.seen = 1; out.seen < 2048; ++out.seen) {
    std::int64_t below = 0;
    bool rises = true;
    for (int s = 1; s < 16 && rises; ++s) {
      // In tenths: shares (seen + 4.8) / kShares - 0.3 s, rounded.
      const std::int64_t tenths =
          (std::int64_t{shares[s]} * (10 * out.seen + 48)) / ResidualStart::kShares - 3 * s + 5;
      const std::int64_t count = tenths < 0 ? -1 : tenths / 10;
      rises = count >= below;
      out.parts[s - 1] = static_cast<std::uint16_t>(count - below);
      below = count;
    }
    if (!rises || below > out.seen) continue;
    out.parts[15] = static_cast<std::uint16_t>(out.seen - below);
    if (same(out.model(), model)) return out;
  }
  out.seen = 0;
  std::uint32_t least = ResidualStart::kShares;
  for (int s = 0; s < 16; ++s)
    least = std::min(least, (s == 15 ? ResidualStart::kShares : shares[s + 1]) - shares[s]);
  out.least = static_cast<std::uint16_t>(least);
  for (int s = 0; s < 16; ++s) {
    out.parts[s] = static_cast<std::uint16_t>((s == 15 ? ResidualStart::kShares : shares[s + 1]) -
                                              shares[s] - least);
  }
  return out;
}

void residuals(StartWriter& writer) {
  ResidualStarts<StartWriter> starts(writer);
  const auto both = [&](const SymbolModel& first, const SymbolModel& second) {
    for (const SymbolModel* model : {&first, &second}) {
      const bool known = model->bounds[0] != 0;
      starts.next(model == &second, {known, known ? start_of(*model) : ResidualStart{}});
    }
  };
  for (int i = 0; i < kShapeContexts; ++i) both(kResiduals[0].shape[i], kResiduals[1].shape[i]);
  for (int i = 0; i < kErrorContexts; ++i) both(kResiduals[0].errors[i], kResiduals[1].errors[i]);
}

void mixed(StartWriter& writer) {
  StartWords<StartWriter> words(writer);
  words.set_stride(kPixelSlots);
  for (std::size_t i = 0; i < kMixStarts; ++i) {
    if (i == std::size_t{kAllPixelContexts} * kPixelSlots) words.set_stride(1);
    words.next_of_both({kMixed[0][i], kMixed[1][i]});
  }
  words.set_stride(kPixelInputs);
  for (const auto& set : kMixedWeights) {
    for (const std::int16_t weight : set) words.next_weight(weight);
  }
}

void tile(StartWriter& writer) {
  StartWords<StartWriter> words(writer);
  for (std::size_t i = 0; i < kTileModelCount; ++i) words.next_of_both({kTile[0][i], kTile[1][i]});
}

void points(StartWriter& writer) {
  StartWords<StartWriter> words(writer);
  words.set_stride(kSiblingStates);
  for (const std::uint16_t start : kOccupancy) words.next(start);
  words.set_stride(1);
  for (const std::uint16_t start : kCounts) words.next(start);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: pack_starts core/wire\n");
    return 2;
  }
  const std::string folder = argv[1];
  if (pack(folder, "residual_models", residuals) && pack(folder, "mix_models", mixed) &&
      pack(folder, "tile_models", tile) && pack(folder, "point_models", points)) {
    return 0;
  }
  std::fprintf(stderr, "pack_starts: %s: cannot be written\n", argv[1]);
  return 1;
}
