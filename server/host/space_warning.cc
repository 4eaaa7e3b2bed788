#include "server/host/space_warning.h"

#include "absl/strings/str_cat.h"

namespace sweepstake::server {

std::optional<std::string> SpaceWarning::Look(uint64_t used_bytes, uint64_t max_bytes,
                                              TimePoint now) {
  if (used_bytes <= max_bytes / 4 * 3) return std::nullopt;
  if (told_ && now - *told_ < kInterval) return std::nullopt;
  told_ = now;
  return absl::StrCat(
      used_bytes >> 20, " MiB of the ", max_bytes >> 20,
      " MiB that it may have (database_mb) are in use, and once it is full nothing more is "
      "acknowledged: raise database_mb, keep less of the audit log (audit_mb), fold evidence "
      "sooner (fold_days), or revoke the token of a client that begins sessions without end; "
      "`sweepstake sessions watch --json` shows from which address each one comes");
}

}  // namespace sweepstake::server
