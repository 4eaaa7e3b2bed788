// A connection to a PostgreSQL server. It is opened at its first use, and again after it was lost,
// but only to the same database as before. Its errors are those of SqlDatabase. If the server
// cannot be reached, a call returns UNAVAILABLE within five seconds.
#pragma once

#include <libpq-fe.h>

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/storage/sql/sql_database.h"

namespace sweepstake::storage {

class PostgresConnection final : public SqlDatabase {
 public:
  // `url` is a postgresql:// URL or a conninfo string of libpq. `settings` are statements that run
  // at each new connection.
  explicit PostgresConnection(std::string url, std::string settings = "")
      : url_(std::move(url)), settings_(std::move(settings)) {}

  // Connects if the connection is missing or lost. Error: UNAVAILABLE, also if the database is not
  // the expected one.
  absl::Status Connect();
  // After this call, connecting fails if the database has another id (PreparePostgresSchema).
  void Expect(std::string store_id) { store_id_ = std::move(store_id); }

  bool shared() const override { return true; }
  uint64_t incarnation() const override { return incarnation_; }
  absl::Status Begin() override;
  absl::Status BeginRead() override;
  absl::Status Commit() override;
  void Rollback() override;
  bool in_transaction() const override;
  absl::Status Execute(const std::string& sql) override { return Query(sql).status(); }

 private:
  struct Closer {
    void operator()(PGconn* connection) const { PQfinish(connection); }
  };
  struct Clearer {
    void operator()(PGresult* result) const { PQclear(result); }
  };
  using Result = std::unique_ptr<PGresult, Clearer>;
  struct Statement {
    std::string name;
    bool is_batch = false;  // contains @given: each parameter is an array with a value per row
  };

  absl::Status Open();
  // Returns an error if the id of the database is not the id that was passed to Expect.
  absl::Status CheckStoreId();
  absl::StatusOr<uint64_t> RunRows(const char* sql, std::span<const SqlValue> values,
                                   size_t columns, OnRow on_row) override;
  // Returns the statement, and prepares it at its first use. `row` shows the types of its
  // parameters.
  absl::StatusOr<Statement> Prepare(const char* sql, std::span<const SqlValue> row);
  absl::StatusOr<Result> Query(const std::string& sql);
  // Takes ownership of the result. Returns the result, or the error that it contains.
  absl::StatusOr<Result> Check(PGresult* result) const;

  const std::string url_;
  const std::string settings_;
  std::string store_id_;  // id of the expected database; empty accepts any database
  std::unique_ptr<PGconn, Closer> connection_;
  std::unordered_map<const char*, Statement> prepared_;  // by the address of the SQL text
  uint64_t incarnation_ = 0;
};

}  // namespace sweepstake::storage
