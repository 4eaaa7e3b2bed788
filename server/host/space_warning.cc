#include "server/host/space_warning.h"

#include "absl/strings/str_cat.h"

namespace sweepstake::server {

std::optional<std::string> SpaceWarning::Look(uint64_t used_bytes, uint64_t max_bytes,
                                              TimePoint now) {
  if (used_bytes <= max_bytes / 4 * 3) return std::nullopt;
  if (warned_ && now - *warned_ < kInterval) return std::nullopt;
  warned_ = now;
  return absl::StrCat(
      used_bytes >> 20, " MiB of the ", max_bytes >> 20,
      " MiB allowed by database_mb are in use, and a full store accepts no new evidence: raise "
      "database_mb, keep less of the audit log (audit_mb), or "
      "revoke the token of a client that starts sessions without end; `sweepstake sessions watch "
      "--json` shows the address of each session");
}

}  // namespace sweepstake::server
