#include "bench/baselines/byte_coders.hpp"

#include "bench/baselines/byte_io.hpp"

#ifdef PLANECAST_HAVE_ZSTD
#include <zstd.h>
#endif
#ifdef PLANECAST_HAVE_BZIP2
#include <bzlib.h>
#endif
#ifdef PLANECAST_HAVE_LZMA
#include <lzma.h>
#endif

namespace planecast::baselines {
namespace {

constexpr std::size_t kMostRaw = std::size_t{1} << 31;  // larger claims are not believed

#ifdef PLANECAST_HAVE_ZSTD
Bytes zstd(int level, std::span<const std::uint8_t> raw) {
  Bytes out(ZSTD_compressBound(raw.size()));
  const std::size_t size = ZSTD_compress(out.data(), out.size(), raw.data(), raw.size(), level);
  if (ZSTD_isError(size) != 0) fail("zstd", ZSTD_getErrorName(size));
  out.resize(size);
  return out;
}
void unzstd(std::span<const std::uint8_t> packed, Bytes& raw) {
  if (ZSTD_decompress(raw.data(), raw.size(), packed.data(), packed.size()) != raw.size())
    fail("zstd", "cannot be decoded");
}
#endif

#ifdef PLANECAST_HAVE_BZIP2
// libbz2 takes char pointers that are not const, and leaves the input alone.
char* chars(const std::uint8_t* p) {
  return reinterpret_cast<char*>(const_cast<std::uint8_t*>(p));
}
Bytes bzip2(int level, std::span<const std::uint8_t> raw) {
  Bytes out(raw.size() + raw.size() / 100 + 600);  // the bound that its manual states
  auto size = static_cast<unsigned>(out.size());
  if (BZ2_bzBuffToBuffCompress(chars(out.data()), &size, chars(raw.data()),
                               static_cast<unsigned>(raw.size()), level, 0, 0) != BZ_OK)
    fail("bzip2", "cannot be encoded");
  out.resize(size);
  return out;
}
void unbzip2(std::span<const std::uint8_t> packed, Bytes& raw) {
  auto size = static_cast<unsigned>(raw.size());
  if (BZ2_bzBuffToBuffDecompress(chars(raw.data()), &size, chars(packed.data()),
                                 static_cast<unsigned>(packed.size()), 0, 0) != BZ_OK ||
      size != raw.size())
    fail("bzip2", "cannot be decoded");
}
#endif

#ifdef PLANECAST_HAVE_LZMA
Bytes xz(int level, std::span<const std::uint8_t> raw) {
  Bytes out(lzma_stream_buffer_bound(raw.size()));
  std::size_t size = 0;
  if (lzma_easy_buffer_encode(static_cast<std::uint32_t>(level), LZMA_CHECK_NONE, nullptr,
                              raw.data(), raw.size(), out.data(), &size, out.size()) != LZMA_OK)
    fail("xz", "cannot be encoded");
  out.resize(size);
  return out;
}
void unxz(std::span<const std::uint8_t> packed, Bytes& raw) {
  std::uint64_t memory = std::uint64_t{1} << 30;
  std::size_t in = 0, out = 0;
  if (lzma_stream_buffer_decode(&memory, 0, nullptr, packed.data(), &in, packed.size(), raw.data(),
                                &out, raw.size()) != LZMA_OK ||
      out != raw.size())
    fail("xz", "cannot be decoded");
}
#endif

}  // namespace

bool available(ByteCoder coder) {
  switch (coder) {
#ifdef PLANECAST_HAVE_ZSTD
    case ByteCoder::kZstd:
      return true;
#endif
#ifdef PLANECAST_HAVE_BZIP2
    case ByteCoder::kBzip2:
      return true;
#endif
#ifdef PLANECAST_HAVE_LZMA
    case ByteCoder::kXz:
      return true;
#endif
    default:
      return false;
  }
}

std::string name_of(ByteCoder coder, int level) {
  const char* const names[] = {"zstd-", "bzip2-", "xz-"};
  return names[static_cast<int>(coder)] + std::to_string(level);
}

Bytes compress(ByteCoder coder, int level, std::span<const std::uint8_t> raw) {
  if (raw.empty()) return {0};  // bzip2 refuses nothing
  Bytes packed;
  switch (coder) {
#ifdef PLANECAST_HAVE_ZSTD
    case ByteCoder::kZstd:
      packed = zstd(level, raw);
      break;
#endif
#ifdef PLANECAST_HAVE_BZIP2
    case ByteCoder::kBzip2:
      packed = bzip2(level, raw);
      break;
#endif
#ifdef PLANECAST_HAVE_LZMA
    case ByteCoder::kXz:
      packed = xz(level, raw);
      break;
#endif
    default:
      fail(name_of(coder, level), "its library is not installed");
  }
  Bytes out;
  put_varint(out, raw.size());
  out.insert(out.end(), packed.begin(), packed.end());
  return out;
}

Bytes decompress(ByteCoder coder, std::span<const std::uint8_t> packed) {
  ByteReader reader(packed);
  const std::uint64_t size = reader.take_varint();
  if (size > kMostRaw) fail(name_of(coder, 0), "cannot be decoded");
  Bytes raw(size);
  if (size == 0) return raw;
  [[maybe_unused]] const auto body = reader.rest();
  switch (coder) {
#ifdef PLANECAST_HAVE_ZSTD
    case ByteCoder::kZstd:
      unzstd(body, raw);
      break;
#endif
#ifdef PLANECAST_HAVE_BZIP2
    case ByteCoder::kBzip2:
      unbzip2(body, raw);
      break;
#endif
#ifdef PLANECAST_HAVE_LZMA
    case ByteCoder::kXz:
      unxz(body, raw);
      break;
#endif
    default:
      fail(name_of(coder, 0), "its library is not installed");
  }
  return raw;
}

}  // namespace planecast::baselines
