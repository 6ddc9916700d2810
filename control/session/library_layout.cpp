#include "control/session/library_layout.hpp"

namespace colift::control {

Layout layout_of_library() {
  return layout_here();
}

}  // namespace colift::control
