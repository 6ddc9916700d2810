#include "hal/dds/participant.hpp"

#include <dds/dds.h>
#include <dds/ddsrt/log.h>
#include <fmt/format.h>
#include <net/if.h>
#include <ros2_messages.h>

#include <map>
#include <mutex>
#include <vector>

#include "hal/dds/loopback.hpp"
#include "hal/dds/ros2_names.hpp"
#include "hal/dds/samples.hpp"

namespace colift::hal::dds {
namespace {

constexpr const char* kLoopback = "lo";

/// Fragments that fit a datagram's 64 KiB, buffers for several depth images, no sample beyond 32 MiB. On the
/// loopback interface there is no multicast; participants find each other at the first 32 well-known ports.
std::string settings_of(const DdsConfig& config) {
  const bool alone = config.interface == kLoopback;
  return fmt::format(
      "<CycloneDDS><Domain Id=\"{}\"><General><Interfaces><NetworkInterface name=\"{}\"{}/></Interfaces>"
      "<AllowMulticast>{}</AllowMulticast><MaxMessageSize>65500B</MaxMessageSize>"
      "<FragmentSize>32000B</FragmentSize></General>"
      "<Discovery><ParticipantIndex>auto</ParticipantIndex>"
      "<MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>{}</Discovery>"
      "<Internal><MaxSampleSize>32MiB</MaxSampleSize><SocketReceiveBufferSize min=\"default\" "
      "max=\"8MiB\"/></Internal>"
      ""
      "<Tracing><Verbosity>none</Verbosity></Tracing></Domain></CycloneDDS>",
      config.domain, config.interface, alone ? " multicast=\"true\"" : "", alone ? "spdp" : "default",
      alone ? "<SPDPInterval>1s</SPDPInterval><Peers><Peer Address=\"127.0.0.1\"/></Peers>" : "");
}

Error fault(const std::string& where, dds_return_t code) {
  return {ErrorCode::DeviceFault, where, dds_strretcode(code)};
}

/// A domain with its settings, shared by all participants in it.
class Domain {
 public:
  static Result<std::shared_ptr<Domain>> of(const DdsConfig& config) {
    static std::mutex mutex;
    static std::map<int, std::weak_ptr<Domain>> all;
    const std::lock_guard lock(mutex);
    if (auto known = all[config.domain].lock()) {
      if (known->interface_ == config.interface) return known;
      return failure(ErrorCode::BadConfig, "ros2.interface",
                     fmt::format("domain {} uses interface {} already, not {}", config.domain,
                                 known->interface_, config.interface));
    }
    if (config.interface.empty() || ::if_nametoindex(config.interface.c_str()) == 0)
      return failure(ErrorCode::BadConfig, "ros2.interface",
                     fmt::format("there is no network interface '{}'", config.interface));
    // it writes a line to the error stream for every message that it cannot read: whoever floods would fill
    // that
    dds_set_log_sink([](void*, const dds_log_data_t*) {}, nullptr);
    const dds_entity_t handle =
        dds_create_domain(static_cast<dds_domainid_t>(config.domain), settings_of(config).c_str());
    if (handle < 0) return tl::unexpected(fault("ros2.domain", handle));
    std::shared_ptr<Domain> made(new Domain(handle, config.interface));
    if (config.interface == kLoopback)
      if (auto tied = tie_to_loopback(config.domain); !tied) return tl::unexpected(tied.error());
    all[config.domain] = made;
    return made;
  }
  ~Domain() { (void)dds_delete(handle_); }
  Domain(const Domain&) = delete;
  Domain& operator=(const Domain&) = delete;

 private:
  Domain(dds_entity_t handle, std::string interface) : handle_(handle), interface_(std::move(interface)) {}
  dds_entity_t handle_;
  std::string interface_;
};

class QosValues {
 public:
  explicit QosValues(Qos qos) : qos_(dds_create_qos()) {
    const QosPolicy policy = policy_of(qos);
    dds_qset_reliability(qos_, policy.reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
                         DDS_MSECS(50));
    dds_qset_durability(qos_,
                        policy.transient_local ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
    if (policy.transient_local)
      dds_qset_durability_service(qos_, 0, DDS_HISTORY_KEEP_LAST, policy.depth, -1, -1, -1);
    dds_qset_history(qos_, DDS_HISTORY_KEEP_LAST, policy.depth);
  }
  ~QosValues() { dds_delete_qos(qos_); }
  QosValues(const QosValues&) = delete;
  QosValues& operator=(const QosValues&) = delete;
  [[nodiscard]] dds_qos_t* get() const { return qos_; }

 private:
  dds_qos_t* qos_;
};

using Graph = rmw_dds_common_msg_dds__ParticipantEntitiesInfo_;
using Gid = rmw_dds_common_msg_dds__Gid_;

}  // namespace

struct Participant::Impl {
  std::shared_ptr<Domain> domain;
  dds_entity_t participant = 0, graph_writer = 0;
  std::string node;
  std::mutex mutex;
  std::vector<dds_guid_t> writers, readers;
  dds_guid_t guid{};

  /// Tells ROS 2 which node has which readers and writers.
  void publish_graph() {
    Sample<Graph> graph(rmw_dds_common_msg_dds__ParticipantEntitiesInfo__desc);
    std::memcpy(graph->gid.data, guid.v, sizeof guid.v);
    auto* info = resize(graph->node_entities_info_seq, 1);
    const auto copy = [](char* to, std::size_t size, const std::string& text) {
      std::memcpy(to, text.data(), std::min(text.size(), size - 1));
    };
    copy(info->node_namespace, sizeof info->node_namespace, "/");
    copy(info->node_name, sizeof info->node_name, node);
    const auto list = [](auto& to, const std::vector<dds_guid_t>& guids) {
      Gid* gids = resize(to, guids.size());
      for (std::size_t i = 0; i < guids.size(); ++i) std::memcpy(gids[i].data, guids[i].v, sizeof guids[i].v);
    };
    list(info->writer_gid_seq, writers);
    list(info->reader_gid_seq, readers);
    (void)dds_write(graph_writer, &*graph);
  }

  Result<dds_entity_t> topic(const std::string& name, const dds_topic_descriptor& type) {
    const dds_entity_t t = dds_create_topic(participant, &type, name.c_str(), nullptr, nullptr);
    if (t < 0) return tl::unexpected(fault("ros2." + name, t));
    return t;
  }

  template <class Create>
  Result<std::int32_t> endpoint(const std::string& ros_name, const dds_topic_descriptor& type, Qos qos,
                                std::vector<dds_guid_t>& list, Create create) {
    const auto name = dds_topic_name(ros_name);
    if (!name) return tl::unexpected(name.error());
    const auto of = topic(*name, type);
    if (!of) return tl::unexpected(of.error());
    const QosValues values(qos);
    const dds_entity_t made = create(participant, *of, values.get(), nullptr);
    if (made < 0) return tl::unexpected(fault("ros2." + *name, made));
    const std::lock_guard lock(mutex);
    dds_guid_t id{};
    if (dds_get_guid(made, &id) == DDS_RETCODE_OK) list.push_back(id);
    publish_graph();
    return made;
  }
};

Participant::Participant(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Participant::~Participant() {
  if (impl_->participant > 0) (void)dds_delete(impl_->participant);
}

Result<std::unique_ptr<Participant>> Participant::open(const DdsConfig& config) {
  if (config.domain < 0 || config.domain > kMaxDomain)
    return failure(ErrorCode::BadConfig, "ros2.domain",
                   fmt::format("{} is no domain; expected 0 to {}", config.domain, kMaxDomain));
  auto impl = std::make_unique<Impl>();
  auto domain = Domain::of(config);
  if (!domain) return tl::unexpected(domain.error());
  impl->domain = std::move(*domain);
  impl->node = config.node;
  dds_qos_t* qos = dds_create_qos();
  constexpr std::string_view kEnclave = "enclave=/;";
  dds_qset_userdata(qos, kEnclave.data(), kEnclave.size());
  impl->participant = dds_create_participant(static_cast<dds_domainid_t>(config.domain), qos, nullptr);
  dds_delete_qos(qos);
  if (impl->participant < 0) return tl::unexpected(fault("ros2.participant", impl->participant));
  (void)dds_get_guid(impl->participant, &impl->guid);
  // its name is not below "rt"
  const auto topic = impl->topic("ros_discovery_info", rmw_dds_common_msg_dds__ParticipantEntitiesInfo__desc);
  if (!topic) return tl::unexpected(topic.error());
  const QosValues latched(Qos::Latched);
  impl->graph_writer = dds_create_writer(impl->participant, *topic, latched.get(), nullptr);
  if (impl->graph_writer < 0) return tl::unexpected(fault("ros2.graph", impl->graph_writer));
  impl->publish_graph();
  return std::unique_ptr<Participant>(new Participant(std::move(impl)));
}

Result<std::int32_t> Participant::writer(const std::string& ros_name, const dds_topic_descriptor& type,
                                         Qos qos) {
  return impl_->endpoint(ros_name, type, qos, impl_->writers, dds_create_writer);
}

Result<std::int32_t> Participant::reader(const std::string& ros_name, const dds_topic_descriptor& type,
                                         Qos qos) {
  return impl_->endpoint(ros_name, type, qos, impl_->readers, dds_create_reader);
}

std::int32_t Participant::handle() const {
  return impl_->participant;
}

}  // namespace colift::hal::dds
