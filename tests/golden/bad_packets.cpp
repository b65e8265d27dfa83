#include "tests/golden/bad_packets.hpp"

#include <functional>

#include "core/base/bytes.hpp"
#include "core/base/crc32c.hpp"
#include "core/base/random.hpp"
#include "core/wire/packet_header.hpp"
#include "core/wire/plc_format.hpp"
#include "core/wire/range_encoder.hpp"
#include "core/wire/run_tile.hpp"

namespace planecast::test {
namespace {

constexpr std::size_t kBody = kPacketHeaderBytes;

void reseal(Bytes& packet) {
  const std::span<const std::uint8_t> all(packet);
  if ((packet[1] & 1U) != 0)
    store_le<std::uint32_t>(packet.data() + 16, crc32c(all.subspan(kBody)));
  store_le<std::uint32_t>(packet.data() + 20, crc32c(all.subspan(kBody), crc32c(all.first(20))));
}

class Collection {
 public:
  explicit Collection(const BadBench& bench) : bench_(bench) {}

  /// `good` after `spoil`, its checks right again unless `keep_checks`.
  void add(Status status, const char* name, Bytes good, const std::function<void(Bytes&)>& spoil,
           bool keep_checks = false) {
    spoil(good);
    if (!keep_checks && good.size() >= kBody) reseal(good);
    const Status found = bench_.decode(name, good);
    if (found != status && first_fault_.empty())
      first_fault_ = std::string(name) + " ends with " + std::string(to_string(found));
    out_.push_back({status, name, std::move(good)});
  }

  /// A byte of the body replaced.
  void add_byte(Status status, const char* name, const Bytes& good, std::size_t at, int value) {
    add(status, name, good, [&](Bytes& b) { b[kBody + at] = static_cast<std::uint8_t>(value); });
  }

  /// A new body from the range coder.
  void add_body(Status status, const char* name, const Bytes& good,
                const std::function<void(RangeEncoder&)>& write) {
    add(status, name, good, [&](Bytes& b) {
      b.resize(kBody + 400);
      RangeEncoder coder{std::span(b).subspan(kBody)};
      write(coder);
      b.resize(kBody + coder.finish());
    });
  }

  /// Changed bits, tried from a seed until they end with `status`.
  void search(Status status, const char* name, const Bytes& good) {
    Pcg32 random(1);
    for (int i = 0; i < 100'000; ++i) {
      Bytes packet = good;
      const auto size = static_cast<std::uint32_t>(packet.size() - kBody);
      packet[kBody + random.below(size)] ^= static_cast<std::uint8_t>(1U << random.below(8));
      reseal(packet);
      if (bench_.decode(name, packet) != status) continue;
      out_.push_back({status, name, std::move(packet)});
      return;
    }
    if (first_fault_.empty()) first_fault_ = std::string(name) + " was not found";
  }

  Result<std::vector<BadPacket>> take() {
    if (!first_fault_.empty()) return Error{Status::kBadConfig, first_fault_};
    return std::move(out_);
  }

 private:
  const BadBench& bench_;
  std::vector<BadPacket> out_;
  std::string first_fault_;
};

void nothing(Bytes&) {}

// A decoder for the sizes of the two streams, with a key packet when there is one; null on failure.
std::unique_ptr<Decoder> decoder_for(std::span<const std::uint8_t> key) {
  auto decoder = Decoder::create({.limits = {160, 120, 800}});
  if (!decoder.ok()) return nullptr;
  if (!key.empty() && (*decoder)->set_key(key) != Status::kOk) return nullptr;
  return std::move(*decoder);
}

// What every packet shares.
void add_headers(Collection& c, const Bytes& key, const Bytes& slice) {
  c.add(Status::kTruncated, "slice_short_header", slice, [](Bytes& b) { b.resize(23); });
  c.add(Status::kBadMagic, "slice_magic", slice, [](Bytes& b) { b[0] = 0x50; });
  c.add(Status::kUnsupportedVersion, "slice_major", slice, [](Bytes& b) { b[0] = 0xc9; });
  c.add(Status::kReservedBits, "slice_attribute_flag", slice, [](Bytes& b) { b[1] |= 2U; });
  c.add(Status::kReservedBits, "key_header_flag", key, [](Bytes& b) { b[1] |= 0x80U; });
  c.add(
      Status::kBadCheck, "slice_changed_bit", slice, [](Bytes& b) { b.back() ^= 1U; }, true);
  c.add(
      Status::kBadCheck, "slice_cut", slice, [](Bytes& b) { b.pop_back(); }, true);
  c.add(Status::kFieldRange, "slice_number", slice, [](Bytes& b) { b[12] = b[13] = 0xff; });
  c.add(Status::kFieldRange, "key_with_slices", key, [](Bytes& b) { b[14] = 1; });
  c.add(Status::kFieldRange, "slice_is_a_key", key, nothing);
  c.add(Status::kFieldRange, "key_is_a_slice", slice, nothing);
  c.add(Status::kUnknownKey, "slice_other_key", slice, [](Bytes& b) { b[16] ^= 0x10U; });
}

void add_keys(Collection& c, const Bytes& key) {
  const auto hash_off = [](Bytes& b) {
    b[16] ^= 1U;
    const std::span<const std::uint8_t> all(b);
    store_le<std::uint32_t>(b.data() + 20, crc32c(all.subspan(kBody), crc32c(all.first(20))));
  };
  c.add(Status::kBadCheck, "key_hash", key, hash_off, true);
  c.add(Status::kTruncated, "key_body_cut", key, [](Bytes& b) { b.pop_back(); });
  c.add(Status::kTruncated, "key_attribute_cut", key, [](Bytes& b) { b.back() = 1; });
  c.add(Status::kTrailingBytes, "key_tail", key, [](Bytes& b) { b.push_back(0); });
  c.add_byte(Status::kUnsupportedVersion, "key_minor", key, 0, 77);
  c.add_byte(Status::kReservedBits, "key_body_flag", key, 2, 0x40);
  c.add_byte(Status::kFieldRange, "key_kind", key, 3, 3);
  c.add_byte(Status::kFieldRange, "key_z_rule", key, 4, 3);
  c.add_byte(Status::kFieldRange, "key_clock", key, 5, 4);
  c.add_byte(Status::kFieldRange, "key_tolerance", key, 6, 4);
  c.add_byte(Status::kFieldRange, "key_drop_without_surfaces", key, 2, 1);
  const auto zeros = [&](const char* name, std::size_t at, std::size_t bytes) {
    c.add(Status::kFieldRange, name, key, [&](Bytes& b) {
      for (std::size_t i = 0; i < bytes; ++i) b[kBody + at + i] = 0;
    });
  };
  zeros("key_width_zero", 26, 2);
  zeros("key_height_zero", 28, 2);
  zeros("key_fx_zero", 30, 4);
  zeros("key_unit_zero", 66, 8);
  zeros("key_period_zero", 24, 2);
  zeros("key_no_rotation", 92, 16);
  c.add(Status::kFieldRange, "key_lattice", key,
        [](Bytes& b) { store_le<std::uint32_t>(b.data() + kBody + 74, 511); });
  c.add(Status::kFieldRange, "key_lens_folds", key,
        [](Bytes& b) { store_le<std::uint32_t>(b.data() + kBody + 46, 0U - (100U << 24U)); });
  c.add_byte(Status::kFieldRange, "key_name_newline", key, 173, '\n');
  c.add(Status::kFrameTooLarge, "key_large_image", key,
        [](Bytes& b) { store_le<std::uint16_t>(b.data() + kBody + 28, 121); });
}

// The depth stream is 160 x 120: 20 x 15 blocks.
void add_slices(Collection& c, const Bytes& slice, const Bytes& raw) {
  const auto rect = [](RangeEncoder& e, std::uint32_t verbatim, int xb, std::uint32_t bx, int yb) {
    e.raw(verbatim, 1);
    e.raw(bx, xb);
    e.raw(0, yb);
    e.raw(1, xb);
    e.raw(1, yb);
  };
  c.add(Status::kTruncated, "slice_empty", slice, [](Bytes& b) { b.resize(kBody); });
  c.add_body(Status::kTruncated, "slice_counts_missing", slice, [&](RangeEncoder& e) {
    rect(e, 1, 5, 3, 4);
    e.raw(kCountsTile, 1);
    for (int i = 0; i < 50; ++i) e.raw(0xabcd, 16);
  });
  c.add_body(Status::kBadSymbol, "slice_run_beyond", slice, [&](RangeEncoder& e) {
    rect(e, 1, 5, 3, 4);
    e.raw(kRunTile, 1);
    SymbolModel run;
    e.symbol(run, kRunToEnd - 1);
    e.raw(0, 6);
    e.raw(0, 16);
  });
  c.add_body(Status::kFieldRange, "slice_outside", slice,
             [&](RangeEncoder& e) { rect(e, 0, 5, 19, 4); });
  c.add_body(Status::kFieldRange, "slice_coefficient", slice, [&](RangeEncoder& e) {
    rect(e, 0, 5, 3, 4);
    e.raw(1000, 16);
    e.raw(1, 6);
    e.raw(20, 5);
    e.raw(20, 5);
  });
  c.add(Status::kTrailingBytes, "slice_tail", slice, [](Bytes& b) { b.resize(b.size() + 9); });
  c.search(Status::kBadSymbol, "slice_symbol", slice);
  c.search(Status::kTruncated, "slice_runs_out", slice);

  c.add(Status::kTruncated, "raw_cut", raw, [](Bytes& b) { b.resize(kBody + 40); });
  c.add(Status::kTrailingBytes, "raw_tail", raw, [](Bytes& b) { b.resize(b.size() + 9); });
  c.add_body(Status::kFieldRange, "raw_axis", raw, [&](RangeEncoder& e) {
    rect(e, 0, 3, 2, 3);
    e.raw(0, 1);
    e.raw(3, 2);
  });
  c.add_body(Status::kFieldRange, "raw_not_finite", raw, [&](RangeEncoder& e) {
    rect(e, 0, 3, 2, 3);
    e.raw(1, 1);
    e.raw(2, 2);
    for (int i = 0; i < 3; ++i) e.raw(0x7ff0, 16);
    for (int i = 0; i < 21; ++i) e.raw(0, 16);
    e.raw(0, 2);
  });
  c.search(Status::kBadSymbol, "raw_symbol", raw);
}

void add_lists(Collection& c, const BadBench& bench) {
  const Bytes &key = bench.points_key, &points = bench.points_slice, &patches = bench.patches_slice;
  const auto number = [&](const char* name, std::size_t at, std::size_t bytes, int value) {
    c.add(Status::kFieldRange, name, key, [&](Bytes& b) {
      for (std::size_t i = 0; i < bytes; ++i) b[kBody + at + i] = static_cast<std::uint8_t>(value);
    });
  };
  number("key_no_points", 26, 4, 0);
  number("key_too_many_points", 26, 4, 0xff);
  number("key_points_without_step", 30, 8, 0);
  number("key_points_beyond_their_bound", 38, 4, 0x0f);
  number("key_patch_unit_zero", 42, 4, 0);
  number("key_fill", 50, 1, 2);
  c.add(Status::kFrameTooLarge, "key_more_points_than_fit", key,
        [](Bytes& b) { b[kBody + 29] = 1; });
  c.add(Status::kTruncated, "points_without_body", points, [](Bytes& b) { b.resize(kBody); });
  c.add(Status::kTrailingBytes, "points_tail", points, [](Bytes& b) { b.resize(b.size() + 9); });
  const auto kind = [&](std::uint32_t value) {
    return [value](RangeEncoder& e) { e.raw(value, 2); };
  };
  c.add_body(Status::kFieldRange, "points_kind", points, kind(3));
  c.add_body(Status::kTooLarge, "points_too_many", points, [](RangeEncoder& e) {
    e.raw(0, 2);  // plain numbers, of a thousand points
    e.raw(10, 6);
    e.raw(1000, 10);
    for (int axis = 0; axis < 3; ++axis) {
      e.raw(0, 1);
      e.raw(0xffff, 16);
      e.raw(0xffff, 16);
    }
  });
  c.search(Status::kBadSymbol, "points_symbol", points);
  c.search(Status::kTruncated, "points_runs_out", points);
  c.add(Status::kTrailingBytes, "patches_tail", patches, [](Bytes& b) { b.resize(b.size() + 9); });
  c.search(Status::kFieldRange, "patches_range", patches);
  c.search(Status::kTruncated, "patches_runs_out", patches);
  c.search(Status::kTooLarge, "patches_too_many", patches);
}

void add_files(Collection& c, std::span<const std::uint8_t> file) {
  const Bytes good(file.begin(), file.end());
  const auto add = [&](Status status, const char* name, const std::function<void(Bytes&)>& spoil) {
    c.add(status, name, good, spoil, true);
  };
  add(Status::kTruncated, "file_header_cut", [](Bytes& b) { b.resize(5); });
  add(Status::kBadMagic, "file_magic", [](Bytes& b) { b[3] = '9'; });
  add(Status::kUnsupportedVersion, "file_major", [](Bytes& b) { b[4] = 3; });
  add(Status::kReservedBits, "file_reserved", [](Bytes& b) { b[7] = 1; });
  add(Status::kFieldRange, "file_record_short", [](Bytes& b) { b[8] = 5; });
  add(Status::kFieldRange, "file_record_huge", [](Bytes& b) { b[11] = 0x20; });
  add(Status::kFieldRange, "file_index_count", [](Bytes& b) { b[b.size() - 37] = 9; });
  add(Status::kBadCheck, "file_trailer", [](Bytes& b) { b[b.size() - 6] ^= 1U; });
  add(Status::kTrailingBytes, "file_tail", [](Bytes& b) { b.push_back(7); });
}

}  // namespace

BadBench::BadBench(std::span<const std::uint8_t> depth, std::span<const std::uint8_t> raw,
                   std::span<const std::uint8_t> points, std::span<const std::uint8_t> patches) {
  const auto first = [](std::span<const std::uint8_t> file, Bytes& its_key, Bytes& its_slice) {
    const auto contents = read_plc(file);
    if (!contents.ok() || contents->frames.empty()) return;
    const PlcFrame& frame = contents->frames[0];
    its_key.assign(frame.key.begin(), frame.key.end());
    its_slice.assign(frame.slices[0].begin(), frame.slices[0].end());
  };
  first(depth, key, depth_slice);
  first(raw, raw_key, raw_slice);
  first(points, points_key, points_slice);
  first(patches, patches_key, patches_slice);
  points_decoder_ = decoder_for(points_key);
  patches_decoder_ = decoder_for(patches_key);
  depth_decoder_ = decoder_for(key);
  raw_decoder_ = decoder_for(raw_key);
}

Status BadBench::decode(std::string_view name, std::span<const std::uint8_t> bytes) const {
  if (name.starts_with("file_")) {
    const auto contents = read_plc(bytes);
    return contents.ok() ? Status::kOk : contents.error().status;
  }
  if (name.starts_with("key_")) {
    const auto fresh = decoder_for({});
    return fresh ? fresh->set_key(bytes) : Status::kOutOfArena;
  }
  Decoder* decoder = name.starts_with("raw_")       ? raw_decoder_.get()
                     : name.starts_with("points_")  ? points_decoder_.get()
                     : name.starts_with("patches_") ? patches_decoder_.get()
                                                    : depth_decoder_.get();
  if (decoder == nullptr) return Status::kBadConfig;
  const Status status = decoder->begin();
  return status == Status::kOk ? decoder->add(bytes) : status;
}

Result<std::vector<BadPacket>> bad_packets(const BadBench& bench,
                                           std::span<const std::uint8_t> small_file) {
  if (bench.depth_slice.empty() || bench.raw_slice.empty() || bench.points_slice.empty() ||
      bench.patches_slice.empty())
    return Error{Status::kBadConfig, "the golden files hold no slices"};
  Collection c(bench);
  add_headers(c, bench.key, bench.depth_slice);
  add_keys(c, bench.key);
  add_slices(c, bench.depth_slice, bench.raw_slice);
  add_lists(c, bench);
  add_files(c, small_file);
  return c.take();
}

}  // namespace planecast::test
