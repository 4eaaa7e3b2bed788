// What builds were made from, in PostgreSQL: as PriorStore says.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/sessions/prior_store.h"
#include "server/storage/postgres/postgres_connection.h"

namespace sweepstake::storage {

// Within a transaction, of checked builds.
absl::Status DescribeBuilds(PostgresConnection& connection, std::span<const priors::Build> builds);
absl::Status ForgetBuilds(PostgresConnection& connection,
                          std::span<const priors::BuildPlace> builds);

// These read one state of the store each, and connect if need be.
absl::StatusOr<std::vector<priors::Build>> LoadBuilds(PostgresConnection& connection,
                                                      const std::string& project,
                                                      std::span<const std::string> names);
absl::StatusOr<std::vector<priors::Build>> ListBuilds(PostgresConnection& connection,
                                                      const priors::SceneFilter& filter,
                                                      const priors::BuildPlace& after,
                                                      uint32_t limit);

}  // namespace sweepstake::storage
