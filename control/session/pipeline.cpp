#include "control/session/pipeline.hpp"

namespace colift::control {

hal::Result<std::unique_ptr<const Pipeline>> make_pipeline(Method method) {
  if (method == Method::Fast) return fast_pipeline();
#ifdef COLIFT_THESIS
  return thesis_pipeline();
#else
  return hal::failure(hal::ErrorCode::BadConfig, "method",
                      "this build has no thesis method (COLIFT_THESIS=OFF)");
#endif
}

}  // namespace colift::control
