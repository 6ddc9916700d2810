#pragma once

namespace colift::hal::dds {

/// Quality of service as tools of ROS 2 expect it.
enum class Qos {
  Reliable,    ///< Commands, states, events: whatever a reader must not miss.
  SensorData,  ///< A reader takes reliable writers too.
  Frames,      ///< Images and clouds, for viewers that insist on reliable ones.
  Newest,      ///< Only what is newest counts.
  Latched,     ///< The last message reaches who comes later, too.
};

/// What one of them is made of. History is always "keep last".
struct QosPolicy {
  bool reliable = true;          ///< Else best effort.
  bool transient_local = false;  ///< Else volatile.
  int depth = 1;                 ///< Messages that are kept.
};

/// The one table: for writers and readers, and for the metadata of a bag.
[[nodiscard]] constexpr QosPolicy policy_of(Qos qos) {
  switch (qos) {
    case Qos::Reliable:
      return {true, false, 10};
    case Qos::SensorData:
      return {false, false, 5};
    case Qos::Frames:
      return {true, false, 2};
    case Qos::Newest:
      return {false, false, 1};
    case Qos::Latched:
      return {true, true, 1};
  }
  return {};
}

}  // namespace colift::hal::dds
