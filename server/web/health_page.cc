#include "server/web/health_page.h"

#include "absl/strings/str_cat.h"

namespace sweepstake::web {

Page HealthPage(std::string_view name, const std::vector<HealthCheck>& checks,
                std::string_view query) {
  std::string list;
  bool passed = true;
  for (const HealthCheck& check : checks) {
    const std::optional<std::string> problem = check.problem();
    passed = passed && !problem;
    absl::StrAppend(&list, problem ? "[-]" : "[+]", check.name,
                    problem ? " failed: " + *problem : " ok",
                    problem || check.note.empty() ? "" : ", but " + check.note, "\n");
  }
  if (!passed)
    return {.status = 503, .body = absl::StrCat(list, std::string(name), " check failed\n")};
  if (!query.starts_with("verbose")) return {.body = "ok\n"};
  return {.body = absl::StrCat(list, std::string(name), " check passed\n")};
}

}  // namespace sweepstake::web
