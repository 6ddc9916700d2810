#include "sim_hal/emulator/krc/krc_wire.hpp"

#include <bit>

namespace colift::sim_hal {
namespace {

/// Writes values one after the other.
class Writer {
 public:
  explicit Writer(std::span<std::byte> into) : into_(into) {}

  void put(std::uint16_t v) { put_bits(v, 2); }
  void put(std::uint32_t v) { put_bits(v, 4); }
  void put(std::int32_t v) { put_bits(static_cast<std::uint32_t>(v), 4); }
  void put(float v) { put_bits(std::bit_cast<std::uint32_t>(v), 4); }
  template <class T, std::size_t N>
  void put(const std::array<T, N>& all) {
    for (const T& v : all) put(v);
  }
  void put(const KrlChannels& krl) {
    put(krl.real);
    put(krl.integer);
    put(krl.boolean);
    put(std::uint16_t{0});
  }

 private:
  void put_bits(std::uint32_t bits, int bytes) {
    for (int i = 0; i < bytes; ++i) into_[at_++] = static_cast<std::byte>((bits >> (8 * i)) & 0xFF);
  }

  std::span<std::byte> into_;
  std::size_t at_ = 0;
};

/// Reads them back; the caller has checked the length.
class Reader {
 public:
  explicit Reader(std::span<const std::byte> from) : from_(from) {}

  void get(std::uint16_t& v) { v = static_cast<std::uint16_t>(bits(2)); }
  void get(std::uint32_t& v) { v = bits(4); }
  void get(std::int32_t& v) { v = static_cast<std::int32_t>(bits(4)); }
  void get(float& v) { v = std::bit_cast<float>(bits(4)); }
  template <class T, std::size_t N>
  void get(std::array<T, N>& all) {
    for (T& v : all) get(v);
  }
  void get(KrlChannels& krl) {
    std::uint16_t fill = 0;
    get(krl.real);
    get(krl.integer);
    get(krl.boolean);
    get(fill);
  }

 private:
  std::uint32_t bits(int bytes) {
    std::uint32_t v = 0;
    for (int i = 0; i < bytes; ++i) v |= std::to_integer<std::uint32_t>(from_[at_++]) << (8 * i);
    return v;
  }

  std::span<const std::byte> from_;
  std::size_t at_ = 0;
};

}  // namespace

std::array<std::byte, kMeasurementBytes> encode(const KrcMeasurement& m) {
  std::array<std::byte, kMeasurementBytes> bytes{};
  Writer w(bytes);
  w.put(m.send);
  w.put(m.reflected);
  w.put(static_cast<std::uint16_t>(kMeasurementBytes));
  w.put(kMeasurementId);
  w.put(m.krl);
  w.put(m.timestamp_s);
  w.put(static_cast<std::uint16_t>(m.state));
  w.put(static_cast<std::uint16_t>(m.quality));
  w.put(m.measurement_period_s);
  w.put(m.command_period_s);
  w.put(m.safety_limits);
  w.put(m.answer_rate);
  w.put(m.latency_s);
  w.put(m.jitter_s);
  w.put(m.miss_rate);
  w.put(m.missed);
  w.put(m.power);
  w.put(static_cast<std::uint16_t>(m.control));
  w.put(m.error);
  w.put(m.warning);
  w.put(m.temperature_c);
  w.put(m.q_rad);
  w.put(m.X_WT);
  w.put(m.q_krl_rad);
  w.put(m.q_offset_rad);
  w.put(m.X_WT_krl);
  w.put(m.X_WT_offset);
  w.put(m.tau_nm);
  w.put(m.tau_external_nm);
  w.put(m.wrench_external);
  w.put(m.jacobian);
  w.put(m.mass_matrix);
  w.put(m.gravity_nm);
  return bytes;
}

std::string_view words(NoCommand why) {
  switch (why) {
    case NoCommand::WrongLength:
      return "wrong length";
    case NoCommand::WrongId:
      return "wrong datagram id";
    case NoCommand::WrongSizeField:
      return "wrong size in the header";
  }
  return "";
}

DecodedCommand decode_command(std::span<const std::byte> bytes) {
  DecodedCommand out;
  if (bytes.size() != kCommandBytes) return out;
  Reader r(bytes);
  KrcCommand c;
  std::uint16_t size = 0, id = 0;
  r.get(c.send);
  r.get(c.reflected);
  r.get(size);
  r.get(id);
  if (id != kCommandId) {
    out.why = NoCommand::WrongId;
    return out;
  }
  if (size != kCommandBytes) {
    out.why = NoCommand::WrongSizeField;
    return out;
  }
  r.get(c.krl);
  r.get(c.flags);
  r.get(c.q_rad);
  r.get(c.X_WT);
  r.get(c.tau_nm);
  r.get(c.wrench);
  r.get(c.stiffness_nm_rad);
  r.get(c.damping);
  r.get(c.cart_stiffness);
  r.get(c.cart_damping);
  out.command = c;
  return out;
}

}  // namespace colift::sim_hal
