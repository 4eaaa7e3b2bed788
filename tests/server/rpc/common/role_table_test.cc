// Tests that every RPC of proto/ has a role, and that its handler checks it.
#include "server/rpc/common/role_table.h"

#include <gmock/gmock.h>
#include <google/protobuf/descriptor.h>
#include <grpcpp/generic/generic_stub.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "tests/server/rpc/common/scripted_tokens.h"
#include "tests/server/rpc/rpc_test_fixture.h"

namespace sweepstake::rpc {
namespace {

// Returns the SERVICE/METHOD names of all RPCs that the files of proto/ declare.
std::set<std::string> DeclaredRpcs() {
  std::set<std::string> names;
  const auto* pool = google::protobuf::DescriptorPool::generated_pool();
  for (const auto& file :
       std::filesystem::directory_iterator(SWEEPSTAKE_PROTO_DIR "/sweepstake/v1")) {
    const auto* proto = pool->FindFileByName("sweepstake/v1/" + file.path().filename().string());
    EXPECT_NE(proto, nullptr) << file.path() << " is not linked into this test";
    for (int i = 0; proto != nullptr && i < proto->service_count(); ++i) {
      const auto* service = proto->service(i);
      for (int j = 0; j < service->method_count(); ++j)
        names.insert(std::string(service->name()) + "/" + std::string(service->method(j)->name()));
    }
  }
  return names;
}

class RoleTableTest : public RpcTest {
 protected:
  RoleTableTest() {
    for (const std::string_view role : auth::kRoleNames)
      tokens_.Add(std::string(role), RoleNamed(role));
    options_.tokens = &tokens_;
  }

  static auth::Role RoleNamed(std::string_view name) {
    return static_cast<auth::Role>(
        std::find(auth::kRoleNames.begin(), auth::kRoleNames.end(), name) -
        auth::kRoleNames.begin());
  }
  // Sends an empty message and returns the status of the call.
  grpc::Status Call(const std::string& rpc, const std::string& token) {
    grpc::GenericStub stub(channel_);
    grpc::CompletionQueue queue;
    grpc::ClientContext context;
    if (!token.empty()) context.AddMetadata("authorization", "Bearer " + token);
    const auto call = stub.PrepareCall(&context, "/sweepstake.v1." + rpc, &queue);
    const auto await = [&queue] {
      void* tag = nullptr;
      bool ok = false;
      EXPECT_TRUE(queue.Next(&tag, &ok));
      return ok;
    };
    call->StartCall(nullptr);
    await();
    grpc::Slice nothing;
    call->Write(grpc::ByteBuffer(&nothing, 1), nullptr);
    await();
    call->WritesDone(nullptr);
    await();
    grpc::ByteBuffer answer;
    do {
      call->Read(&answer, nullptr);
    } while (await());
    grpc::Status status;
    call->Finish(&status, nullptr);
    await();
    return status;
  }

  ScriptedTokens tokens_;
};

TEST(RoleTable, HasExactlyOneRowPerRpc) {
  std::set<std::string> rows;
  for (const Rpc& rpc : kRoleTable) rows.insert(std::string(rpc.name));
  EXPECT_EQ(rows, DeclaredRpcs());
  EXPECT_EQ(rows.size(), kRoleTable.size());
}

TEST_F(RoleTableTest, EveryHandlerRefusesACallWithoutItsRole) {
  for (const Rpc& rpc : kRoleTable) {
    const std::string name(rpc.name);
    // Time passes, so that the limit of failures is not reached.
    clock_.Advance(auth::FailureLimit::kIntervalNs);
    EXPECT_EQ(Call(name, "").error_code(), grpc::StatusCode::UNAUTHENTICATED) << name;
    EXPECT_EQ(Call(name, "other-token").error_code(), grpc::StatusCode::UNAUTHENTICATED) << name;
    for (const std::string_view role : auth::kRoleNames) {
      if (auth::Includes(RoleNamed(role), rpc.role)) continue;
      EXPECT_EQ(Call(name, std::string(role) + "-token").error_code(),
                grpc::StatusCode::PERMISSION_DENIED)
          << name << " by " << role;
    }
  }
}

TEST_F(RoleTableTest, ACallWithItsRoleIsServed) {
  EXPECT_TRUE(Call("PosteriorsService/ListPosteriors", "watch-token").ok());
  EXPECT_TRUE(Call("PosteriorsService/ListPosteriors", "operator-token").ok());
  EXPECT_TRUE(Call("PriorsService/ImportPriors", "operator-token").ok());
  EXPECT_TRUE(Call("PriorsService/ImportPriors", "admin-token").ok());
  EXPECT_TRUE(Call("AuditService/ExportDecisions", "admin-token").ok());
  EXPECT_EQ(Call("TelemetryService/StreamTelemetry", "ingest-token").error_code(),
            grpc::StatusCode::FAILED_PRECONDITION)
      << "no Hello";
}

}  // namespace
}  // namespace sweepstake::rpc
