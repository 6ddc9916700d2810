#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "tools/live/board.hpp"
#include "tools/live/foxglove_wire.hpp"
#include "tools/live/live_server.hpp"

namespace colift::live {

/// A client that receives channels, as the hub sees it. All calls come from the server's thread.
class Listener {
 public:
  virtual ~Listener() = default;
  virtual void deliver(Post& post) = 0;
  /// What the robot's clock says.
  virtual void tell_time(hal::Timestamp now) = 0;
};

/// A connection that speaks HTTP, as the hub sees it. All calls come from the server's thread.
class Caller {
 public:
  virtual ~Caller() = default;
  /// Has to leave: its place is needed.
  virtual void turn_out() = 0;
};

/// What all connections share: configuration, files, the board, who listens. Lives in the server's thread,
/// except for what says otherwise.
class Hub {
 public:
  Hub(const ServerConfig& config, PageFiles files) : config_(config), files_(std::move(files)) {}

  [[nodiscard]] const ServerConfig& config() const { return config_; }
  [[nodiscard]] const PageFiles& files() const { return files_; }
  [[nodiscard]] const Board& board() const { return board_; }
  [[nodiscard]] const std::string& session() const { return session_; }
  /// Of the newest message; unset before the first.
  [[nodiscard]] std::optional<hal::Timestamp> now() const { return now_; }
  void set_session(std::string session) { session_ = std::move(session); }

  void join(Listener* listener) { listeners_.insert(listener); }
  void leave(Listener* listener) { listeners_.erase(listener); }

  /// Somebody has connected. Where all places are taken whoever has been idle longest leaves: connections
  /// that say nothing lock nobody out.
  void call(Caller* caller);
  /// It has asked for something: of all, it is the last to leave.
  void renew(Caller* caller);
  void hang_up(Caller* caller);
  /// Whether one more client of the channels may come.
  [[nodiscard]] bool has_place(bool operates) const {
    return listening_ < config_.most_clients + (operates ? config_.operator_places : 0);
  }
  void take_place() { ++listening_; }
  void leave_place() { --listening_; }

  /// Any thread. True: nobody has been notified yet that something waits.
  [[nodiscard]] bool hand_in(const telemetry::Publication& publication);
  /// Takes what was handed in and passes it on.
  void pass_on();

  // any thread
  std::atomic<std::uint64_t> clients{0}, clients_ever{0}, turned_away{0}, published{0}, dropped{0}, sent{0};

 private:
  static constexpr std::size_t kMostWaiting = 4000;

  const ServerConfig config_;
  const PageFiles files_;
  std::string session_;
  Board board_;
  std::optional<hal::Timestamp> now_, published_;
  std::set<Listener*> listeners_;
  std::vector<Caller*> callers_;  ///< The longest idle first.
  std::size_t listening_ = 0;     ///< Clients of the channels, from their upgrade on.

  std::mutex waiting_mutex_;
  std::vector<telemetry::Publication> waiting_;
  std::vector<telemetry::Publication> taken_;
};

}  // namespace colift::live
