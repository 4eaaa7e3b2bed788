#include "server/storage/postgres/postgres_connection.h"

#include <array>
#include <charconv>
#include <cstring>

#include "absl/strings/escaping.h"
#include "absl/strings/strip.h"

namespace sweepstake::storage {
namespace {

constexpr double kUnitsPerOne = 0x1p20;

// The defaults of a connection; its URL may set others. A server that does not answer is given up
// after ten seconds, and a lock of another daemon after the same time.
constexpr std::array kDefaults = {
    std::pair("connect_timeout", "5"), std::pair("tcp_user_timeout", "10000"),
    std::pair("application_name", "sweepstaked"), std::pair("client_encoding", "UTF8")};
constexpr const char* kSetUp =
    "SET search_path = sweepstake; SET lock_timeout = '10s'; SET client_min_messages = warning; "
    "SET standard_conforming_strings = on; SET synchronous_commit = on";

absl::StatusCode CodeOf(std::string_view sql_state) {
  if (sql_state == "40001" || sql_state == "40P01") return absl::StatusCode::kAborted;
  if (sql_state == "23514" || sql_state == "22003") return absl::StatusCode::kInvalidArgument;
  if (sql_state.substr(0, 2) == "XX") return absl::StatusCode::kDataLoss;
  return absl::StatusCode::kUnavailable;
}

// libpq ends its messages with line ends.
std::string Line(const char* message) {
  return std::string(absl::StripTrailingAsciiWhitespace(message));
}

}  // namespace

Units UnitsOf(double amount) { return Units(amount * kUnitsPerOne); }

double AmountOf(Units units) { return static_cast<double>(units) / kUnitsPerOne; }

std::string TextOf(Units value) {
  const auto small = static_cast<int64_t>(value);
  if (Units(small) == value) return absl::StrCat(small);
  const bool negative = value < 0;
  std::string digits;
  do {
    const int digit = static_cast<int>(value % 10);
    digits.insert(digits.begin(), static_cast<char>('0' + (digit < 0 ? -digit : digit)));
    value /= 10;
  } while (value != 0);
  return negative ? "-" + digits : digits;
}

void PostgresArray::Add(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted.push_back('\\');
    quoted.push_back(c);
  }
  Append(quoted + "\"");
}

void PostgresArray::AddBytes(std::string_view bytes) {
  Append(absl::StrCat("\"\\\\x", absl::BytesToHexString({bytes.data(), bytes.size()}), "\""));
}

int64_t PostgresRow::Integer(int column) const {
  const char* text = PQgetvalue(result_, row_, column);
  int64_t value = 0;
  std::from_chars(text, text + PQgetlength(result_, row_, column), value);
  return value;
}

Units PostgresRow::Number(int column) const {
  Units value = 0;
  const char* text = PQgetvalue(result_, row_, column);
  const bool negative = *text == '-';
  for (text += negative ? 1 : 0; *text >= '0' && *text <= '9'; ++text)
    value = value * 10 + (*text - '0');
  return negative ? -value : value;
}

std::string PostgresRow::Text(int column) const {
  return {PQgetvalue(result_, row_, column),
          static_cast<size_t>(PQgetlength(result_, row_, column))};
}

std::string PostgresRow::Bytes(int column) const {
  return absl::HexStringToBytes(Text(column).substr(std::strlen("\\x")));
}

absl::Status PostgresConnection::Connect() {
  if (connection_ != nullptr && PQstatus(connection_.get()) == CONNECTION_OK)
    return absl::OkStatus();
  prepared_.clear();
  // A URL in the place of a database name overrides the parameters before it.
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
    const std::string why = Line(PQerrorMessage(connection_.get()));
    connection_.reset();
    return absl::UnavailableError(absl::StrCat(
        "PostgreSQL cannot be reached: ", why,
        "; see that the server runs, that the URL is its, and that it lets this user in"));
  }
  // libpq would print warnings to stderr, which the daemon uses for its log.
  PQsetNoticeProcessor(
      connection_.get(), [](void*, const char*) {}, nullptr);
  ++incarnation_;
  return Execute(kSetUp);
}

absl::Status PostgresConnection::Execute(const std::string& sql) {
  if (connection_ == nullptr) return absl::UnavailableError("there is no connection to PostgreSQL");
  const Result result(PQexec(connection_.get(), sql.c_str()));
  return Check(result.get());
}

absl::StatusOr<PostgresConnection::Result> PostgresConnection::RunPrepared(
    const char* sql, const std::vector<std::string>& texts) {
  if (connection_ == nullptr) return absl::UnavailableError("there is no connection to PostgreSQL");
  std::string& name = prepared_[sql];
  if (name.empty()) {
    const std::string given = absl::StrCat("s", prepared_.size());
    const Result result(PQprepare(connection_.get(), given.c_str(), sql, 0, nullptr));
    if (absl::Status status = Check(result.get()); !status.ok()) {
      prepared_.erase(sql);
      return status;
    }
    name = given;
  }
  std::vector<const char*> values;
  for (const std::string& text : texts) values.push_back(text.c_str());
  Result result(PQexecPrepared(connection_.get(), name.c_str(), static_cast<int>(values.size()),
                               values.data(), nullptr, nullptr, /*resultFormat=*/0));
  if (absl::Status status = Check(result.get()); !status.ok()) return status;
  return result;
}

absl::Status PostgresConnection::RunOnce(const std::string& sql,
                                         const std::vector<PostgresArray>& arrays) {
  if (connection_ == nullptr) return absl::UnavailableError("there is no connection to PostgreSQL");
  std::vector<std::string> texts;
  std::vector<const char*> values;
  for (const PostgresArray& array : arrays) texts.push_back(array.text());
  for (const std::string& text : texts) values.push_back(text.c_str());
  const Result result(PQexecParams(connection_.get(), sql.c_str(), static_cast<int>(values.size()),
                                   nullptr, values.data(), nullptr, nullptr, /*resultFormat=*/0));
  return Check(result.get());
}

absl::Status PostgresConnection::Check(const PGresult* result) const {
  const ExecStatusType status = PQresultStatus(result);
  if (status == PGRES_COMMAND_OK || status == PGRES_TUPLES_OK) return absl::OkStatus();
  if (result == nullptr || PQstatus(connection_.get()) != CONNECTION_OK) {
    return absl::UnavailableError(absl::StrCat("the connection to PostgreSQL was lost: ",
                                               Line(PQerrorMessage(connection_.get()))));
  }
  const char* state = PQresultErrorField(result, PG_DIAG_SQLSTATE);
  return {CodeOf(state == nullptr ? "" : state),
          absl::StrCat("PostgreSQL: ", Line(PQresultErrorMessage(result)))};
}

PostgresSnapshot::PostgresSnapshot(PostgresConnection& connection)
    : connection_(connection), status_(connection.Connect()) {
  if (!status_.ok() || PQtransactionStatus(connection_.connection_.get()) != PQTRANS_IDLE) return;
  status_ = connection_.Execute("BEGIN ISOLATION LEVEL REPEATABLE READ READ ONLY");
  begun_ = status_.ok();
}

PostgresSnapshot::~PostgresSnapshot() {
  if (begun_) connection_.Execute("ROLLBACK").IgnoreError();
}

}  // namespace sweepstake::storage
