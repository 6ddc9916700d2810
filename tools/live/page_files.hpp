#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace colift::live {

/// What is sent for one path.
struct Document {
  std::string type;  ///< MIME type.
  std::string body;
};

/// What the server has to show: the built page on disk, and documents that the run made.
class PageFiles {
 public:
  /// `folder` holds index.html; it may not be there (then index() explains what is missing).
  explicit PageFiles(std::filesystem::path folder) : folder_(std::move(folder)) {}

  void add(const std::string& path, Document document) {
    made_[path] = std::make_shared<const Document>(std::move(document));
  }

  /// The document for a request's target ("/", "/assets/index.js?x"); null: there is none. Never leaves
  /// the folder, and reads only kinds of files that a page is made of.
  [[nodiscard]] std::shared_ptr<const Document> find(std::string_view target) const;

  /// Beside the running program ("dashboard"), or where it was installed ("../share/colift/dashboard").
  [[nodiscard]] static std::filesystem::path beside_program();

 private:
  std::filesystem::path folder_;
  std::map<std::string, std::shared_ptr<const Document>> made_;
};

/// "/assets/index.js" of a request's target: without query, decoded. nullopt for what no honest client asks.
[[nodiscard]] std::optional<std::string> clean_path(std::string_view target);

}  // namespace colift::live
