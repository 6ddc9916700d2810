#include "hal/drivers/recorded/recorded_camera.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

namespace colift::hal {
namespace {

namespace fs = std::filesystem;

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

// depth_9 before depth_10.
bool by_number(const fs::path& left, const fs::path& right) {
  const std::string a = left.filename().string(), b = right.filename().string();
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (is_digit(a[i]) && is_digit(b[j])) {
      const auto number = [](const std::string& text, std::size_t& at) {
        while (at + 1 < text.size() && text[at] == '0' && is_digit(text[at + 1])) ++at;
        const std::size_t begin = at;
        while (at < text.size() && is_digit(text[at])) ++at;
        return text.substr(begin, at - begin);
      };
      const std::string m = number(a, i), n = number(b, j);
      if (m.size() != n.size()) return m.size() < n.size();
      if (m != n) return m < n;
    } else {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i;
      ++j;
    }
  }
  if (a.size() - i != b.size() - j) return a.size() - i < b.size() - j;
  return a < b;  // equal but for leading zeros
}

bool has_extension(const fs::path& file, std::string_view wanted) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return extension == wanted;
}

Result<std::vector<fs::path>> frames_in(const fs::path& folder) {
  std::vector<fs::path> images, clouds;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const fs::path& file = entry->path();
    if (has_extension(file, ".png") && file.filename().string().starts_with("depth")) images.push_back(file);
    if (has_extension(file, ".pcd") || has_extension(file, ".ply")) clouds.push_back(file);
  }
  if (error)
    return failure(ErrorCode::BadConfig, folder.string(), "the folder cannot be read: " + error.message());
  // both kinds together are usually the same frames twice
  std::vector<fs::path>& out = images.empty() ? clouds : images;
  if (out.empty()) {
    return failure(ErrorCode::BadConfig, folder.string(), "the folder holds no depth*.png, *.pcd or *.ply");
  }
  std::sort(out.begin(), out.end(), by_number);
  return out;
}

}  // namespace

Result<> RecordedCamera::configure() {
  deactivate();
  files_.clear();
  next_ = 0;
  handed_out_ = 0;
  failed_in_a_row_ = 0;
  health_ = {};
  if (!(config_.period_s > 0.0 && config_.period_s <= 3600.0)) {
    return failure(ErrorCode::BadConfig, "recorded_camera.period_s",
                   fmt::format("period_s is {}; expected more than 0 and at most 3600 s", config_.period_s));
  }
  if (!listed_.empty()) {
    files_ = listed_;
    return {};
  }
  const fs::path path = config_.path;
  std::error_code error;
  if (path.empty() || !fs::exists(path, error)) {
    return failure(ErrorCode::BadConfig, path.empty() ? "recorded_camera.path" : path.string(),
                   path.empty() ? "no recording is named" : "there is no such file or folder");
  }
  if (!fs::is_directory(path, error)) {
    files_ = {path};
    return {};
  }
  auto found = frames_in(path);
  if (!found) return tl::unexpected(found.error());
  files_ = std::move(*found);
  return {};
}

Result<> RecordedCamera::activate() {
  if (files_.empty())
    return failure(ErrorCode::NotReady, "recorded_camera.activate", "configure() has found no recording yet");
  active_ = true;
  health_.state = DeviceHealth::State::Streaming;
  return {};
}

void RecordedCamera::deactivate() noexcept {
  active_ = false;
}

Result<DepthFrame> RecordedCamera::next_frame(std::chrono::milliseconds /*timeout*/) {
  if (!active_)
    return failure(ErrorCode::NotReady, "recorded_camera.next_frame", "the camera is not activated");
  const bool at_end = next_ >= files_.size();
  // a loop over damaged files alone would never end
  if (at_end && (!config_.loop || failed_in_a_row_ >= files_.size())) {
    health_.state = DeviceHealth::State::Lost;
    health_.last_error = fmt::format("the recording of {} frames has ended", files_.size());
    return failure(ErrorCode::LinkLost, "recorded_camera.next_frame", health_.last_error);
  }
  if (at_end) next_ = 0;
  auto read = read_frame(files_[next_++]);
  const std::uint64_t number = handed_out_++;
  if (!read) {
    ++health_.rejected;
    ++failed_in_a_row_;
    health_.last_error = read.error().text();
    return tl::unexpected(read.error());
  }
  failed_in_a_row_ = 0;
  ++health_.accepted;
  X_FC_ = read->X_FC;
  read->frame.exposed_at =
      std::chrono::nanoseconds(std::llround(config_.period_s * 1e9 * static_cast<double>(number)));
  return std::move(read->frame);
}

}  // namespace colift::hal
