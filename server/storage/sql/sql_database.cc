#include "server/storage/sql/sql_database.h"

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"

namespace sweepstake::storage {
namespace {

// Removes each part between the two marks in `removed`, such as "{}", together with the marks. Of
// the marks in `unwrapped`, removes only the marks and keeps the text between them.
std::string WithoutParts(std::string_view sql, std::string_view removed,
                         std::string_view unwrapped) {
  std::string text;
  bool inside = false;
  for (const char c : sql) {
    if (removed.find(c) != std::string_view::npos) {
      inside = c == removed[0];
    } else if (!inside && unwrapped.find(c) == std::string_view::npos) {
      text.push_back(c);
    }
  }
  return text;
}

// Returns SQL for the parameter rows as a table g with the columns p1, p2 …
std::string GivenRows(std::span<const char* const> types) {
  std::string arrays, names;
  for (size_t i = 0; i < types.size(); ++i) {
    const char* comma = i == 0 ? "" : ", ";
    absl::StrAppend(&arrays, comma, "$", i + 1, "::", types[i], "[]");
    absl::StrAppend(&names, comma, "p", i + 1);
  }
  return absl::StrCat("unnest(", arrays, ") AS g(", names, ")");
}

}  // namespace

absl::Status InTransaction(SqlDatabase& database, absl::FunctionRef<absl::Status()> body) {
  absl::Status status = database.Begin();
  if (!status.ok()) return status;
  status = body();
  if (status.ok()) status = database.Commit();
  if (!status.ok()) database.Rollback();
  return status;
}

SqlSnapshot::SqlSnapshot(SqlDatabase& database)
    : database_(database), nested_(database.in_transaction()) {
  if (!nested_) status_ = database_.BeginRead();
}

SqlSnapshot::~SqlSnapshot() {
  if (!nested_) database_.Rollback();
}

std::string SqliteText(std::string_view sql) { return WithoutParts(sql, "{}", "[]"); }

std::string PostgresText(std::string_view sql, std::span<const char* const> types) {
  std::string text = absl::StrReplaceAll(WithoutParts(sql, "[]", "{}"),
                                         {{"instr(", "strpos("}, {"char(10)", "chr(10)"}});
  const bool is_batch = absl::StrContains(text, "@given");
  for (size_t i = types.size(); i > 0; --i) {  // replaces ?10 before ?1, because ?10 begins with ?1
    const std::string parameter =
        is_batch ? absl::StrCat("g.p", i) : absl::StrCat("$", i, "::", types[i - 1]);
    text = absl::StrReplaceAll(text, {{absl::StrCat("?", i), parameter}});
  }
  return absl::StrReplaceAll(text, {{"@given", GivenRows(types)}});
}

std::string LineList(std::span<const std::string> lines) {
  std::string list;
  for (const std::string& line : lines)
    absl::StrAppend(&list, list.empty() ? "\n" : "", line, "\n");
  return list;
}

}  // namespace sweepstake::storage
