#include "server/storage/postgres/postgres_connection.h"

#include <array>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>

#include "absl/strings/escaping.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/strip.h"

namespace sweepstake::storage {
namespace {

constexpr double kUnitsPerOne = 0x1p20;

// Default connection parameters; the URL can override them. Connecting fails after 5 s, and a
// connection after 10 s without acknowledgement of sent data (10000 ms). kSetUp limits the wait for
// another daemon's lock to 10 s.
constexpr std::array kDefaults = {
    std::pair("connect_timeout", "5"), std::pair("tcp_user_timeout", "10000"),
    std::pair("application_name", "sweepstaked"), std::pair("client_encoding", "UTF8")};
constexpr const char* kSetUp =
    "SET search_path = sweepstake; SET lock_timeout = '10s'; SET client_min_messages = warning; "
    "SET standard_conforming_strings = on; SET synchronous_commit = on; ";

absl::StatusCode CodeOf(std::string_view sql_state) {
  if (sql_state == "40001" || sql_state == "40P01") return absl::StatusCode::kAborted;
  if (sql_state == "23514" || sql_state == "22003") return absl::StatusCode::kInvalidArgument;
  if (sql_state.substr(0, 2) == "XX") return absl::StatusCode::kDataLoss;
  return absl::StatusCode::kUnavailable;
}

// Removes the line end with which libpq ends its messages.
std::string Line(const char* message) {
  return std::string(absl::StripTrailingAsciiWhitespace(message));
}

// Returns an amount below 1e15 as a whole number of units of 2⁻²⁰, in decimal digits. The number is
// below 2⁷⁰, so it may exceed int64_t.
std::string UnitsOf(double amount) {
  const double units = amount * kUnitsPerOne;
  if (units < 0x1p62) return absl::StrCat(static_cast<int64_t>(units));
  std::array<char, 32> digits;
  const int size = std::snprintf(digits.data(), digits.size(), "%.0f", units);
  return {digits.data(), static_cast<size_t>(size)};
}

struct TypeName {
  const char* operator()(int64_t) const { return "bigint"; }
  const char* operator()(bool) const { return "boolean"; }
  const char* operator()(SqlAmount) const { return "numeric"; }
  const char* operator()(std::string_view) const { return "text"; }
  const char* operator()(SqlBytes) const { return "bytea"; }
};

struct ParameterText {
  std::string operator()(int64_t value) const { return absl::StrCat(value); }
  std::string operator()(bool value) const { return value ? "t" : "f"; }
  std::string operator()(SqlAmount amount) const { return UnitsOf(amount.value); }
  std::string operator()(std::string_view text) const { return std::string(text); }
  std::string operator()(SqlBytes bytes) const {
    return absl::StrCat("\\x", absl::BytesToHexString({bytes.value.data(), bytes.value.size()}));
  }
};

// Returns one column of the parameter rows as the text of a PostgreSQL array.
std::string ArrayText(std::span<const SqlValue> values, size_t columns, size_t column) {
  std::string array = "{";
  for (size_t i = column; i < values.size(); i += columns) {
    if (i > column) array.push_back(',');
    const std::string text = std::visit(ParameterText(), values[i]);
    const bool is_text = std::holds_alternative<std::string_view>(values[i]) ||
                         std::holds_alternative<SqlBytes>(values[i]);
    if (is_text) {
      absl::StrAppend(&array, "\"", absl::StrReplaceAll(text, {{"\\", "\\\\"}, {"\"", "\\\""}}),
                      "\"");
    } else {
      array += text;
    }
  }
  return array + "}";
}

class PostgresRow final : public SqlRow {
 public:
  PostgresRow(const PGresult* result, int row) : result_(result), row_(row) {}

  int64_t Integer(int column) const override {
    const char* text = Value(column);
    int64_t value = 0;
    const auto read = std::from_chars(text, text + PQgetlength(result_, row_, column), value);
    return read.ec == std::errc() ? value : std::numeric_limits<int64_t>::max();
  }
  bool Boolean(int column) const override { return *Value(column) == 't'; }
  double Amount(int column) const override {
    return std::strtod(Value(column), nullptr) / kUnitsPerOne;
  }
  uint64_t Count(int column) const override { return Unsigned(column); }
  std::string Text(int column) const override {
    return {Value(column), static_cast<size_t>(PQgetlength(result_, row_, column))};
  }
  std::string Bytes(int column) const override {
    return absl::HexStringToBytes(Value(column) + std::strlen("\\x"));
  }

 private:
  const char* Value(int column) const { return PQgetvalue(result_, row_, column); }

  const PGresult* result_;
  int row_;
};

}  // namespace

absl::Status PostgresConnection::Connect() {
  if (connection_ != nullptr && PQstatus(connection_.get()) == CONNECTION_OK)
    return absl::OkStatus();
  prepared_.clear();
  absl::Status status = Open();
  if (status.ok()) status = Execute(kSetUp + settings_);
  if (status.ok()) status = CheckStoreId();
  if (status.ok()) {
    ++incarnation_;
  } else {
    connection_.reset();
  }
  return status;
}

absl::Status PostgresConnection::Open() {
  // libpq expands a URL that is given as `dbname`. The URL overrides the parameters before it in
  // the list.
  std::vector<const char*> names;
  std::vector<const char*> values;
  for (const auto& [name, value] : kDefaults) {
    names.push_back(name);
    values.push_back(value);
  }
  names.insert(names.end(), {"dbname", nullptr});
  values.insert(values.end(), {url_.c_str(), nullptr});
  connection_.reset(PQconnectdbParams(names.data(), values.data(), /*expand_dbname=*/1));
  if (PQstatus(connection_.get()) != CONNECTION_OK) {
    return absl::UnavailableError(
        absl::StrCat("PostgreSQL cannot be reached: ", Line(PQerrorMessage(connection_.get())),
                     "; check that the server runs, that the URL is correct, and that the server "
                     "accepts this user"));
  }
  // libpq would print warnings to stderr, which the daemon uses for its log.
  PQsetNoticeProcessor(
      connection_.get(), [](void*, const char*) {}, nullptr);
  return absl::OkStatus();
}

absl::Status PostgresConnection::CheckStoreId() {
  if (store_id_.empty()) return absl::OkStatus();
  const auto id = ReadText("SELECT id FROM store");
  if (!id.ok() || *id == store_id_) return id.status();
  return absl::UnavailableError(
      "the database in PostgreSQL is not the one that this daemon used before; put that one back, "
      "or restart the daemon to use this one");
}

absl::Status PostgresConnection::Begin() {
  absl::Status status = Connect();
  return status.ok() ? Execute("BEGIN") : status;
}

absl::Status PostgresConnection::BeginRead() {
  absl::Status status = Connect();
  return status.ok() ? Execute("BEGIN ISOLATION LEVEL REPEATABLE READ READ ONLY") : status;
}

absl::Status PostgresConnection::Commit() {
  const auto result = Query("COMMIT");
  if (!result.ok()) return result.status();
  // After an error in the transaction, COMMIT rolls back and succeeds. Only its command tag shows
  // that nothing was committed.
  if (std::string_view(PQcmdStatus(result->get())) == "COMMIT") return absl::OkStatus();
  return absl::UnavailableError("PostgreSQL has rolled the transaction back");
}

void PostgresConnection::Rollback() {
  if (in_transaction()) Execute("ROLLBACK").IgnoreError();
}

bool PostgresConnection::in_transaction() const {
  if (connection_ == nullptr) return false;
  const PGTransactionStatusType status = PQtransactionStatus(connection_.get());
  return status == PQTRANS_INTRANS || status == PQTRANS_INERROR;
}

absl::StatusOr<PostgresConnection::Statement> PostgresConnection::Prepare(
    const char* sql, std::span<const SqlValue> row) {
  const auto found = prepared_.find(sql);
  if (found != prepared_.end()) return found->second;
  std::vector<const char*> types;
  for (const SqlValue& value : row) types.push_back(std::visit(TypeName(), value));
  const Statement statement{.name = absl::StrCat("s", prepared_.size()),
                            .is_batch = absl::StrContains(sql, "@given")};
  const auto result = Check(PQprepare(connection_.get(), statement.name.c_str(),
                                      PostgresText(sql, types).c_str(), 0, nullptr));
  if (!result.ok()) return result.status();
  prepared_.emplace(sql, statement);
  return statement;
}

absl::StatusOr<uint64_t> PostgresConnection::RunRows(const char* sql,
                                                     std::span<const SqlValue> values,
                                                     size_t columns, OnRow on_row) {
  if (stopped()) return absl::CancelledError("the statement was stopped");
  if (connection_ == nullptr) return absl::UnavailableError("there is no connection to PostgreSQL");
  const auto statement = Prepare(sql, values.first(columns));
  if (!statement.ok()) return statement.status();
  std::vector<std::string> texts;
  std::vector<const char*> parameters;
  for (size_t i = 0; i < columns; ++i)
    texts.push_back(statement->is_batch ? ArrayText(values, columns, i)
                                        : std::visit(ParameterText(), values[i]));
  for (const std::string& text : texts) parameters.push_back(text.c_str());
  const auto result = Check(PQexecPrepared(connection_.get(), statement->name.c_str(),
                                           static_cast<int>(parameters.size()), parameters.data(),
                                           nullptr, nullptr, /*resultFormat=*/0));
  if (!result.ok()) return result.status();
  for (int row = 0; row < PQntuples(result->get()); ++row) on_row(PostgresRow(result->get(), row));
  return std::strtoull(PQcmdTuples(result->get()), nullptr, 10);
}

absl::StatusOr<PostgresConnection::Result> PostgresConnection::Query(const std::string& sql) {
  if (connection_ == nullptr) return absl::UnavailableError("there is no connection to PostgreSQL");
  return Check(PQexec(connection_.get(), sql.c_str()));
}

absl::StatusOr<PostgresConnection::Result> PostgresConnection::Check(PGresult* result) const {
  Result owned(result);
  const ExecStatusType status = PQresultStatus(result);
  if (status == PGRES_COMMAND_OK || status == PGRES_TUPLES_OK) return owned;
  if (result == nullptr || PQstatus(connection_.get()) != CONNECTION_OK) {
    return absl::UnavailableError(absl::StrCat("the connection to PostgreSQL was lost: ",
                                               Line(PQerrorMessage(connection_.get()))));
  }
  const char* state = PQresultErrorField(result, PG_DIAG_SQLSTATE);
  return absl::Status(CodeOf(state == nullptr ? "" : state),
                      absl::StrCat("PostgreSQL: ", Line(PQresultErrorMessage(result))));
}

}  // namespace sweepstake::storage
