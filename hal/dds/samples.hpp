#pragma once

#include <dds/dds.h>

#include <cstring>
#include <string_view>
#include <utility>

// Messages as Cyclone DDS keeps them: C structs whose strings and sequences are owned. Only .cpp files
// include this.

namespace colift::hal::dds {

/// A message that is built here. What is not set is zero or empty.
template <class T>
class Sample {
 public:
  explicit Sample(const dds_topic_descriptor_t& type)
      : type_(&type), message_(static_cast<T*>(dds_alloc(sizeof(T)))) {
    std::memset(static_cast<void*>(message_), 0, sizeof(T));
  }
  ~Sample() { dds_sample_free(message_, type_, DDS_FREE_ALL); }
  Sample(const Sample&) = delete;
  Sample& operator=(const Sample&) = delete;
  T* operator->() { return message_; }
  T& operator*() { return *message_; }

 private:
  const dds_topic_descriptor_t* type_;
  T* message_;
};

/// Replaces a string; a NUL ends it, as in C.
inline void set(char*& to, std::string_view text) {
  dds_free(to);
  char* copy = static_cast<char*>(dds_alloc(text.size() + 1));
  std::memcpy(copy, text.data(), text.size());
  copy[text.size()] = '\0';
  to = copy;
}

/// Makes an empty sequence one of `size` zeroed elements.
template <class Sequence>
auto* resize(Sequence& s, std::size_t size) {
  using Element = std::remove_pointer_t<decltype(s._buffer)>;
  if (size > 0) {
    s._buffer = static_cast<Element*>(dds_alloc(size * sizeof(Element)));
    std::memset(static_cast<void*>(s._buffer), 0, size * sizeof(Element));
  }
  s._length = s._maximum = static_cast<std::uint32_t>(size);
  s._release = true;
  return s._buffer;
}

inline std::string_view text_of(const char* text) {
  return text == nullptr ? std::string_view() : std::string_view(text);
}

/// Messages that were received: lent by the reader until this is gone.
template <class T, int kMax = 16>
class Taken {
 public:
  /// Takes what the reader has, `kMax` at most.
  explicit Taken(dds_entity_t reader) : reader_(reader) {
    const dds_return_t n = dds_take(reader, samples_, infos_, kMax, kMax);
    count_ = n > 0 ? n : 0;
  }
  ~Taken() {
    if (count_ > 0) (void)dds_return_loan(reader_, samples_, count_);
  }
  Taken(const Taken&) = delete;
  Taken& operator=(const Taken&) = delete;
  [[nodiscard]] int size() const { return count_; }
  /// Null: only news about the writer.
  [[nodiscard]] const T* at(int i) const {
    return infos_[i].valid_data ? static_cast<const T*>(samples_[i]) : nullptr;
  }
  [[nodiscard]] dds_instance_handle_t writer(int i) const { return infos_[i].publication_handle; }

 private:
  dds_entity_t reader_;
  void* samples_[kMax] = {};
  dds_sample_info_t infos_[kMax] = {};
  int count_ = 0;
};

}  // namespace colift::hal::dds
