// A prior store on the test program's own server.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>

#include "server/storage/postgres/postgres_prior_store.h"
#include "tests/support/postgres/postgres_server.h"

namespace sweepstake::storage {

// Starts the server at the first use; it ends with the program.
inline test_support::PostgresServer& Server() {
  static test_support::PostgresServer server;
  return server;
}

// Opens the store; the test fails if that fails.
inline std::unique_ptr<priors::PriorStore> OpenStore(const std::string& url,
                                                     const priors::AuditLimits& limits = {}) {
  auto store = OpenPostgresPriorStore(url, limits);
  if (!store.ok()) ADD_FAILURE() << store.status();
  return *std::move(store);
}

}  // namespace sweepstake::storage
