#include "server/rpc/health_probe.h"

#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/security/tls_certificate_provider.h>
#include <grpcpp/security/tls_certificate_verifier.h>

#include <future>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"

namespace sweepstake::rpc {
namespace {

// The bytes of a HealthCheckResponse whose status is SERVING.
constexpr std::string_view kServingBytes = "\x08\x01";

absl::StatusOr<std::shared_ptr<grpc::ChannelCredentials>> ProbeCredentials(
    const tls::Files& files) {
  if (files.cert.empty()) return grpc::InsecureChannelCredentials();
  const auto texts = tls::Read(files);
  if (!texts.ok()) return texts.status();
  using grpc::experimental::IdentityKeyCertPair;
  grpc::experimental::TlsChannelCredentialsOptions options;
  options.set_verify_server_certs(false);
  options.set_check_call_host(false);
  options.set_certificate_verifier(std::make_shared<grpc::experimental::NoOpCertificateVerifier>());
  options.set_certificate_provider(
      std::make_shared<grpc::experimental::StaticDataCertificateProvider>(
          std::vector<IdentityKeyCertPair>{{texts->key, texts->cert}}));
  options.watch_identity_key_cert_pairs();
  return grpc::experimental::TlsCredentials(options);
}

// Returns advice for the reason of a failed probe; empty if the reason is not known. It recognizes
// error texts of gRPC 1.51 and OpenSSL 3.
std::string Advice(const std::string& reason, const tls::Files& files) {
  const auto has = [&](const char* words) { return reason.find(words) != std::string::npos; };
  if (has("Connection refused")) return "; is the daemon running there?";
  if (has("wrong version number"))
    return "; the daemon uses plain text: omit --tls-cert and --tls-key";
  if (!has("Socket closed") && !has("Connection reset by peer") && !has("Broken pipe") &&
      !has("Endpoint read failed"))
    return "";
  if (files.cert.empty()) return "; the daemon may require TLS: give its --tls-cert and --tls-key";
  return "; if the daemon uses --tls-client-ca, that authority must accept the daemon's own "
         "certificate as a client certificate, and it must not have expired";
}

}  // namespace

absl::StatusOr<Health> HealthOf(const std::shared_ptr<grpc::Channel>& channel,
                                std::chrono::milliseconds patience) {
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + patience);
  const grpc::ByteBuffer request(nullptr, 0);  // an empty request means the whole server
  grpc::ByteBuffer response;
  std::promise<grpc::Status> done;
  grpc::GenericStub(channel).UnaryCall(
      &context, "/grpc.health.v1.Health/Check", {}, &request, &response,
      [&done](grpc::Status status) { done.set_value(std::move(status)); });
  if (const grpc::Status status = done.get_future().get(); !status.ok())
    return absl::UnavailableError(status.error_message());
  grpc::Slice bytes;
  const bool serving =
      response.DumpToSingleSlice(&bytes).ok() &&
      std::string_view(reinterpret_cast<const char*>(bytes.begin()), bytes.size()) == kServingBytes;
  return serving ? Health::kServing : Health::kNotServing;
}

absl::StatusOr<Health> ProbeHealth(const std::string& address, const tls::Files& files,
                                   std::chrono::milliseconds patience) {
  const auto credentials = ProbeCredentials(files);
  if (!credentials.ok()) return credentials.status();
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  auto health = HealthOf(grpc::CreateCustomChannel(address, *credentials, arguments), patience);
  if (health.ok()) return health;
  const std::string reason(health.status().message());
  return absl::UnavailableError(reason + Advice(reason, files));
}

}  // namespace sweepstake::rpc
