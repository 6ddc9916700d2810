#pragma once

#include <pthread.h>

namespace colift::hal {

/// A mutex whose holder runs with the priority of whoever waits for it (POSIX PTHREAD_PRIO_INHERIT): a
/// real-time thread that shares something with an ordinary one waits for that one only, and not for everybody
/// who has taken the processor from it. Never in the arm's own cycle, which shares nothing.
class InheritingMutex {
 public:
  InheritingMutex() {
    pthread_mutexattr_t attributes;
    pthread_mutexattr_init(&attributes);
    pthread_mutexattr_setprotocol(&attributes, PTHREAD_PRIO_INHERIT);
    pthread_mutex_init(&mutex_, &attributes);
    pthread_mutexattr_destroy(&attributes);
  }
  ~InheritingMutex() { pthread_mutex_destroy(&mutex_); }
  InheritingMutex(const InheritingMutex&) = delete;
  InheritingMutex& operator=(const InheritingMutex&) = delete;

  void lock() { pthread_mutex_lock(&mutex_); }
  void unlock() { pthread_mutex_unlock(&mutex_); }

 private:
  pthread_mutex_t mutex_;
};

}  // namespace colift::hal
