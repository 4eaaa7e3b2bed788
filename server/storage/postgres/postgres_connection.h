// A connection to a PostgreSQL server. It is opened at its first use, and again after it was lost.
// Used by one thread at a time.
//
// Errors: UNAVAILABLE (the server cannot be reached, stops, or refuses; trying again may help),
// ABORTED (a conflict with another daemon; the transaction can be repeated at once),
// INVALID_ARGUMENT (a value is out of a column's bounds), DATA_LOSS (the server found damage).
#pragma once

#include <libpq-fe.h>

#include <concepts>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "absl/numeric/int128.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"

namespace sweepstake::storage {

// Evidence in the database, in whole units of 2⁻²⁰, whose sums have no rounding errors. An amount
// is below 1e15, which is 2⁷⁰ units.
using Units = absl::int128;
// REQUIRES: `amount` is finite, and InUnits.
Units UnitsOf(double amount);
double AmountOf(Units units);
std::string TextOf(Units value);

// An array of values of one column, for a parameter such as `$1::bigint[]`.
class PostgresArray {
 public:
  void Add(std::integral auto number) { Append(absl::StrCat(number)); }
  void Add(Units number) { Append(TextOf(number)); }
  void Add(std::string_view text);
  // Adds bytes for a `bytea` column.
  void AddBytes(std::string_view bytes);
  std::string text() const { return text_ + "}"; }

 private:
  void Append(const std::string& element) {
    absl::StrAppend(&text_, text_.size() > 1 ? "," : "", element);
  }
  std::string text_ = "{";
};

// One row of a result. Columns count from 0.
class PostgresRow {
 public:
  PostgresRow(const PGresult* result, int row) : result_(result), row_(row) {}

  int64_t Integer(int column) const;
  uint64_t Unsigned(int column) const { return static_cast<uint64_t>(Integer(column)); }
  bool Boolean(int column) const { return *PQgetvalue(result_, row_, column) == 't'; }
  // Reads a numeric column.
  Units Number(int column) const;
  std::string Text(int column) const;
  // Reads a bytea column.
  std::string Bytes(int column) const;

 private:
  const PGresult* result_;
  int row_;
};

class PostgresConnection {
 public:
  // `url` is a postgresql:// URL or a conninfo string of libpq.
  explicit PostgresConnection(std::string url) : url_(std::move(url)) {}

  // Connects if the connection is missing or lost. Then prepared statements are forgotten, and
  // incarnation() grows.
  absl::Status Connect();
  uint64_t incarnation() const { return incarnation_; }
  // Runs several statements without parameters, and ignores their results.
  absl::Status Execute(const std::string& sql);
  // Runs a statement and calls `on_row(const PostgresRow&)` for each row. The statement is prepared
  // at its first use.
  template <typename OnRow, typename... Args>
  absl::Status ForEachRow(const char* sql, OnRow on_row, const Args&... args) {
    const std::vector<std::string> texts = {ParameterOf(args)...};
    const auto result = RunPrepared(sql, texts);
    if (!result.ok()) return result.status();
    for (int row = 0; row < PQntuples(result->get()); ++row)
      on_row(PostgresRow(result->get(), row));
    return absl::OkStatus();
  }
  template <typename... Args>
  absl::Status Run(const char* sql, const Args&... args) {
    return ForEachRow(
        sql, [](const PostgresRow&) {}, args...);
  }
  // Runs a statement and returns how many rows it has changed.
  template <typename... Args>
  absl::StatusOr<uint64_t> Change(const char* sql, const Args&... args) {
    const std::vector<std::string> texts = {ParameterOf(args)...};
    const auto result = RunPrepared(sql, texts);
    if (!result.ok()) return result.status();
    return std::strtoull(PQcmdTuples(result->get()), nullptr, 10);
  }
  // Runs a statement that is used once, with an array for each parameter.
  absl::Status RunOnce(const std::string& sql, const std::vector<PostgresArray>& arrays);

 private:
  struct Closer {
    void operator()(PGconn* connection) const { PQfinish(connection); }
  };
  struct Clearer {
    void operator()(PGresult* result) const { PQclear(result); }
  };
  using Result = std::unique_ptr<PGresult, Clearer>;

  static std::string ParameterOf(const PostgresArray& array) { return array.text(); }
  static std::string ParameterOf(std::string_view text) { return std::string(text); }
  static std::string ParameterOf(bool value) { return value ? "t" : "f"; }
  static std::string ParameterOf(std::integral auto number) { return absl::StrCat(number); }

  absl::StatusOr<Result> RunPrepared(const char* sql, const std::vector<std::string>& texts);
  // Returns OK for a successful result, and otherwise its error.
  absl::Status Check(const PGresult* result) const;

  friend class PostgresSnapshot;

  const std::string url_;
  std::unique_ptr<PGconn, Closer> connection_;
  std::unordered_map<std::string, std::string> prepared_;  // names by statement text
  uint64_t incarnation_ = 0;
};

// Connects, and makes all reads in its scope see one state of the database. A nested scope uses the
// state of the outer one.
class PostgresSnapshot {
 public:
  explicit PostgresSnapshot(PostgresConnection& connection);
  ~PostgresSnapshot();
  PostgresSnapshot(const PostgresSnapshot&) = delete;
  PostgresSnapshot& operator=(const PostgresSnapshot&) = delete;

  const absl::Status& status() const { return status_; }

 private:
  PostgresConnection& connection_;
  absl::Status status_;
  bool begun_ = false;
};

}  // namespace sweepstake::storage
