#include "tests/dds/fast_peer.hpp"

#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/DataWriterListener.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>

#include <condition_variable>
#include <cstring>
#include <deque>
#include <map>
#include <mutex>
#include <stdexcept>

namespace colift::tests {
namespace {

namespace fd = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;

constexpr std::uint32_t kLargest = 8u << 20;

// A type that is nothing but its name.
class BytesType final : public fd::TopicDataType {
 public:
  explicit BytesType(const std::string& name) {
    setName(name.c_str());
    m_typeSize = kLargest;
    m_isGetKeyDefined = false;
    auto_fill_type_information(false);
    auto_fill_type_object(false);
  }
  bool serialize(void* data, rtps::SerializedPayload_t* to) override {
    const auto& bytes = *static_cast<Bytes*>(data);
    if (bytes.size() > to->max_size) return false;
    std::memcpy(to->data, bytes.data(), bytes.size());
    to->length = static_cast<std::uint32_t>(bytes.size());
    to->encapsulation = bytes.size() > 1 && bytes[1] == 0 ? CDR_BE : CDR_LE;
    return true;
  }
  bool deserialize(rtps::SerializedPayload_t* from, void* data) override {
    static_cast<Bytes*>(data)->assign(from->data, from->data + from->length);
    return true;
  }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] { return static_cast<std::uint32_t>(static_cast<Bytes*>(data)->size()); };
  }
  void* createData() override { return new Bytes; }
  void deleteData(void* data) override { delete static_cast<Bytes*>(data); }
  bool getKey(void*, rtps::InstanceHandle_t*, bool) override { return false; }
};

Bytes bytes_of(const rtps::GUID_t& guid) {
  Bytes b(guid.guidPrefix.value, guid.guidPrefix.value + 12);
  b.insert(b.end(), guid.entityId.value, guid.entityId.value + 4);
  return b;
}

template <class Q>
void apply(const PeerQos& from, Q& to) {
  to.reliability().kind = from.reliable ? fd::RELIABLE_RELIABILITY_QOS : fd::BEST_EFFORT_RELIABILITY_QOS;
  to.durability().kind = from.latched ? fd::TRANSIENT_LOCAL_DURABILITY_QOS : fd::VOLATILE_DURABILITY_QOS;
  to.history().kind = fd::KEEP_LAST_HISTORY_QOS;
  to.history().depth = from.depth;
  to.endpoint().history_memory_policy = rtps::DYNAMIC_RESERVE_MEMORY_MODE;
}

class FastReader final : public FastPeer::Reader, fd::DataReaderListener {
 public:
  FastReader(fd::Subscriber* owner, fd::Topic* topic, const PeerQos& qos) : owner_(owner) {
    fd::DataReaderQos values = owner->get_default_datareader_qos();
    apply(qos, values);
    reader_ = owner->create_datareader(topic, values, this);
    if (reader_ == nullptr) throw std::runtime_error("no reader");
  }
  ~FastReader() override {
    reader_->set_listener(nullptr);
    owner_->delete_datareader(reader_);
  }
  std::optional<Bytes> next(std::chrono::milliseconds timeout) override {
    std::unique_lock lock(mutex_);
    if (!news_.wait_for(lock, timeout, [&] { return !received_.empty(); })) return std::nullopt;
    Bytes first = std::move(received_.front());
    received_.pop_front();
    return first;
  }
  Bytes matched_writer() override {
    const std::lock_guard lock(mutex_);
    return matched_;
  }

 private:
  void on_data_available(fd::DataReader* reader) override {
    Bytes bytes;
    fd::SampleInfo info;
    while (reader->take_next_sample(&bytes, &info) == ReturnCode_t::RETCODE_OK) {
      if (!info.valid_data) continue;
      const std::lock_guard lock(mutex_);
      received_.push_back(bytes);
      news_.notify_all();
    }
  }
  void on_subscription_matched(fd::DataReader*, const fd::SubscriptionMatchedStatus& status) override {
    const std::lock_guard lock(mutex_);
    matched_.clear();
    if (status.current_count > 0) matched_ = bytes_of(rtps::iHandle2GUID(status.last_publication_handle));
  }

  fd::Subscriber* owner_;
  fd::DataReader* reader_ = nullptr;
  std::mutex mutex_;
  std::condition_variable news_;
  std::deque<Bytes> received_;
  Bytes matched_;
};

class FastWriter final : public FastPeer::Writer, fd::DataWriterListener {
 public:
  FastWriter(fd::Publisher* owner, fd::Topic* topic, const PeerQos& qos) : owner_(owner) {
    fd::DataWriterQos values = owner->get_default_datawriter_qos();
    apply(qos, values);
    values.publish_mode().kind = fd::ASYNCHRONOUS_PUBLISH_MODE;
    values.reliability().max_blocking_time = eprosima::fastrtps::Duration_t(1, 0);
    writer_ = owner->create_datawriter(topic, values, this);
    if (writer_ == nullptr) throw std::runtime_error("no writer");
  }
  ~FastWriter() override {
    writer_->set_listener(nullptr);
    owner_->delete_datawriter(writer_);
  }
  bool write(const Bytes& message) override { return writer_->write(const_cast<Bytes*>(&message)); }
  bool wait_for_readers(int count, std::chrono::milliseconds timeout) override {
    std::unique_lock lock(mutex_);
    return news_.wait_for(lock, timeout, [&] { return readers_ >= count; });
  }

 private:
  void on_publication_matched(fd::DataWriter*, const fd::PublicationMatchedStatus& status) override {
    const std::lock_guard lock(mutex_);
    readers_ = status.current_count;
    news_.notify_all();
  }

  fd::Publisher* owner_;
  fd::DataWriter* writer_ = nullptr;
  std::mutex mutex_;
  std::condition_variable news_;
  int readers_ = 0;
};

}  // namespace

struct FastPeer::Impl {
  fd::DomainParticipant* participant = nullptr;
  fd::Publisher* publisher = nullptr;
  fd::Subscriber* subscriber = nullptr;
  std::map<std::string, fd::Topic*> topics;

  fd::Topic* topic(const std::string& name, const std::string& type) {
    auto& known = topics[name];
    if (known == nullptr) {
      fd::TypeSupport(new BytesType(type)).register_type(participant);
      known = participant->create_topic(name, type, fd::TOPIC_QOS_DEFAULT);
    }
    if (known == nullptr) throw std::runtime_error("no topic " + name);
    return known;
  }
};

FastPeer::FastPeer(int domain, bool all_interfaces) : impl_(std::make_unique<Impl>()) {
  fd::DomainParticipantQos qos;
  qos.transport().use_builtin_transports = false;
  const auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  udp->sendBufferSize = udp->receiveBufferSize = 4u << 20;
  if (!all_interfaces) udp->interfaceWhiteList.push_back("127.0.0.1");
  qos.transport().user_transports.push_back(udp);
  impl_->participant = fd::DomainParticipantFactory::get_instance()->create_participant(
      static_cast<fd::DomainId_t>(domain), qos);
  if (impl_->participant == nullptr) throw std::runtime_error("no participant");
  impl_->publisher = impl_->participant->create_publisher(fd::PUBLISHER_QOS_DEFAULT);
  impl_->subscriber = impl_->participant->create_subscriber(fd::SUBSCRIBER_QOS_DEFAULT);
}

FastPeer::~FastPeer() {
  impl_->participant->delete_contained_entities();
  fd::DomainParticipantFactory::get_instance()->delete_participant(impl_->participant);
}

std::unique_ptr<FastPeer::Reader> FastPeer::reader(const std::string& topic, const std::string& type,
                                                   PeerQos qos) {
  return std::make_unique<FastReader>(impl_->subscriber, impl_->topic(topic, type), qos);
}

std::unique_ptr<FastPeer::Writer> FastPeer::writer(const std::string& topic, const std::string& type,
                                                   PeerQos qos) {
  return std::make_unique<FastWriter>(impl_->publisher, impl_->topic(topic, type), qos);
}

}  // namespace colift::tests
