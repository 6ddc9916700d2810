#include "tools/visualization/report/report.hpp"

#include "tools/visualization/file_output.hpp"
#include "tools/visualization/report/report_parts.hpp"

namespace colift::picture {

std::string report_html(const Report& report) {
  std::string body = report_paragraphs(report.summary);
  for (const ReportPicture& picture : report.pictures) body += report_figure(picture);
  body += report_candidates(report.candidates);
  body += report_list("Surfaces", report.surfaces);
  body += report_list("Notes", report.notes);
  body += report_times(report.timing);
  body += report_pairs("Facts", report.facts);
  body += report_pairs("Configuration that differs from the defaults", report.config);
  body += report_command(report.command);
  return report_page(report.title, "", ReportTone::Plain, body);
}

hal::Result<> write_report(const std::filesystem::path& html, const Report& report) {
  const std::string page = report_html(report);
  return write_file(html, {reinterpret_cast<const std::uint8_t*>(page.data()), page.size()});
}

}  // namespace colift::picture
