// JPEG 2000 by OpenJPEG, lossless: reversible 5/3 wavelets, five levels, arithmetic-coded bit
// planes. Depth edges and holes are hard for it; smooth time-of-flight depth suits it.
#include "bench/baselines/depth_baselines.hpp"

#ifdef PLANECAST_HAVE_OPENJPEG
#include <openjpeg.h>

#include <algorithm>
#include <cstring>

namespace planecast::baselines {
namespace {

// A stream of OpenJPEG on bytes in memory: it reads, writes, skips and seeks by these.
struct Memory {
  Bytes bytes;
  std::size_t at = 0;

  static OPJ_SIZE_T read(void* to, OPJ_SIZE_T size, void* self) {
    auto& m = *static_cast<Memory*>(self);
    if (m.at >= m.bytes.size()) return static_cast<OPJ_SIZE_T>(-1);
    size = std::min<OPJ_SIZE_T>(size, m.bytes.size() - m.at);
    std::memcpy(to, m.bytes.data() + m.at, size);
    m.at += size;
    return size;
  }
  static OPJ_SIZE_T write(void* from, OPJ_SIZE_T size, void* self) {
    auto& m = *static_cast<Memory*>(self);
    m.bytes.resize(std::max(m.bytes.size(), m.at + size));
    std::memcpy(m.bytes.data() + m.at, from, size);
    m.at += size;
    return size;
  }
  static OPJ_OFF_T skip(OPJ_OFF_T size, void* self) {
    static_cast<Memory*>(self)->at += static_cast<std::size_t>(size);
    return size;
  }
  static OPJ_BOOL seek(OPJ_OFF_T to, void* self) {
    static_cast<Memory*>(self)->at = static_cast<std::size_t>(to);
    return OPJ_TRUE;
  }
};

struct Destroy {
  void operator()(opj_image_t* p) const { opj_image_destroy(p); }
  void operator()(opj_codec_t* p) const { opj_destroy_codec(p); }
};
struct DestroyStream {
  void operator()(opj_stream_t* p) const { opj_stream_destroy(p); }
};
using Image = std::unique_ptr<opj_image_t, Destroy>;
using Codec = std::unique_ptr<opj_codec_t, Destroy>;
// opj_codec_t and opj_stream_t are both void pointers.
using Stream = std::unique_ptr<opj_stream_t, DestroyStream>;

Stream open(Memory& memory, bool input) {
  Stream stream(opj_stream_default_create(input ? OPJ_TRUE : OPJ_FALSE));
  opj_stream_set_user_data(stream.get(), &memory, nullptr);
  opj_stream_set_user_data_length(stream.get(), memory.bytes.size());
  opj_stream_set_read_function(stream.get(), Memory::read);
  opj_stream_set_write_function(stream.get(), Memory::write);
  opj_stream_set_skip_function(stream.get(), Memory::skip);
  opj_stream_set_seek_function(stream.get(), Memory::seek);
  return stream;
}

class Jpeg2000Depth : public DepthBaseline {
 public:
  Jpeg2000Depth() : DepthBaseline("JPEG2000", "lossless") {}

  Bytes encode(const DepthImage& depth) const override {
    opj_image_cmptparm_t part{};
    part.dx = part.dy = 1;
    part.w = depth.width;
    part.h = depth.height;
    part.prec = 16;
    const Image image(opj_image_create(1, &part, OPJ_CLRSPC_GRAY));
    image->x1 = depth.width;
    image->y1 = depth.height;
    std::copy(depth.depth.begin(), depth.depth.end(), image->comps[0].data);
    opj_cparameters_t parameters;
    opj_set_default_encoder_parameters(&parameters);  // lossless, six resolutions
    parameters.tcp_numlayers = 1;
    parameters.cp_disto_alloc = 1;
    const Codec codec(opj_create_compress(OPJ_CODEC_J2K));
    Memory memory;
    {
      const Stream stream = open(memory, false);
      if (!opj_setup_encoder(codec.get(), &parameters, image.get()) ||
          !opj_start_compress(codec.get(), image.get(), stream.get()) ||
          !opj_encode(codec.get(), stream.get()) || !opj_end_compress(codec.get(), stream.get()))
        fail(name(), "cannot be encoded");
    }
    return memory.bytes;
  }

  DepthImage decode(const Bytes& bytes) const override {
    const Codec codec(opj_create_decompress(OPJ_CODEC_J2K));
    opj_dparameters_t parameters;
    opj_set_default_decoder_parameters(&parameters);
    Memory memory{bytes};
    const Stream stream = open(memory, true);
    opj_image_t* raw = nullptr;
    if (!opj_setup_decoder(codec.get(), &parameters) ||
        !opj_read_header(stream.get(), codec.get(), &raw))
      fail(name(), "cannot be decoded");
    const Image image(raw);
    if (!opj_decode(codec.get(), stream.get(), image.get()) || image->numcomps != 1)
      fail(name(), "cannot be decoded");
    DepthImage out{image->comps[0].w, image->comps[0].h, {}};
    const OPJ_INT32* begin = image->comps[0].data;
    out.depth.assign(begin, begin + std::size_t{out.width} * out.height);
    return out;
  }
};

}  // namespace

std::unique_ptr<DepthBaseline> jpeg2000_depth() {
  return std::make_unique<Jpeg2000Depth>();
}
bool jpeg2000_available() {
  return true;
}

}  // namespace planecast::baselines

#else

namespace planecast::baselines {
std::unique_ptr<DepthBaseline> jpeg2000_depth() {
  fail("JPEG2000", "libopenjp2-7-dev is missing");
}
bool jpeg2000_available() {
  return false;
}
}  // namespace planecast::baselines

#endif
