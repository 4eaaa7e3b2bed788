#include "engine_client/telemetry/daemon_channel.h"

#include <grpcpp/support/client_interceptor.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <utility>
#include <vector>

#include "engine_client/telemetry/protocol/wire.h"
#include "engine_client/telemetry/tls/tls_files.h"

namespace sweepstake {
namespace {

bool Has(const std::string& text, const char* part) { return text.find(part) != text.npos; }

constexpr size_t kMaxTokenBytes = 4096;

Result<std::string> ReadTokenFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string text(kMaxTokenBytes + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<size_t>(file.gcount()));
  if (text.empty() || text.size() > kMaxTokenBytes) {
    return Status(StatusCode::kInvalidArgument,
                  "cannot read a token from " + path +
                      "; name the file that `sweepstaked token create --out` wrote");
  }
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back())) != 0)
    text.pop_back();
  return text;
}

// Returns the token from its file or its text. Empty if neither is set.
Result<std::string> TokenText(const ClientToken& token) {
  if (!token.file.empty() && !token.text.empty())
    return Status(StatusCode::kInvalidArgument, "set either a token or a token file, not both");
  std::string text = token.text;
  if (!token.file.empty()) {
    auto read = ReadTokenFile(token.file);
    if (!read.ok()) return read.status();
    text = *std::move(read);
    if (text.empty())
      return Status(StatusCode::kInvalidArgument, token.file + " contains no token");
  }
  const bool printable =
      std::all_of(text.begin(), text.end(), [](char c) { return c > ' ' && c <= '~'; });
  if (printable && text.size() <= kMaxTokenBytes) return text;
  return Status(
      StatusCode::kInvalidArgument,
      (token.file.empty() ? std::string("the given text") : token.file) +
          " is not a token: it contains spaces or invalid characters, or exceeds 4096 bytes");
}

// Adds the token to each call. gRPC's call credentials are not used, because they work only with
// TLS.
class TokenSender final : public grpc::experimental::Interceptor {
 public:
  explicit TokenSender(std::string authorization) : authorization_(std::move(authorization)) {}

  void Intercept(grpc::experimental::InterceptorBatchMethods* methods) override {
    if (methods->QueryInterceptionHookPoint(
            grpc::experimental::InterceptionHookPoints::PRE_SEND_INITIAL_METADATA)) {
      methods->GetSendInitialMetadata()->emplace("authorization", authorization_);
    }
    methods->Proceed();
  }

 private:
  const std::string authorization_;
};

class TokenSenderFactory final : public grpc::experimental::ClientInterceptorFactoryInterface {
 public:
  explicit TokenSenderFactory(const std::string& token) : authorization_("Bearer " + token) {}

  grpc::experimental::Interceptor* CreateClientInterceptor(
      grpc::experimental::ClientRpcInfo* /*call*/) override {
    return new TokenSender(authorization_);
  }

 private:
  const std::string authorization_;
};

std::shared_ptr<grpc::Channel> MakeChannel(
    const std::string& address, const std::shared_ptr<grpc::ChannelCredentials>& credentials,
    const grpc::ChannelArguments& arguments, const std::string& token) {
  if (token.empty()) return grpc::CreateCustomChannel(address, credentials, arguments);
  std::vector<std::unique_ptr<grpc::experimental::ClientInterceptorFactoryInterface>> senders;
  senders.push_back(std::make_unique<TokenSenderFactory>(token));
  return grpc::experimental::CreateCustomChannelWithInterceptors(address, credentials, arguments,
                                                                 std::move(senders));
}

// Returns whether the daemon closed the connection during its setup. The daemon rejects clients in
// this way. The error text depends on which side wrote first.
bool IsHungUp(const std::string& reason) {
  return Has(reason, "Socket closed") || Has(reason, "Connection reset by peer") ||
         Has(reason, "Broken pipe") || Has(reason, "Endpoint read failed");
}

}  // namespace

Result<std::shared_ptr<grpc::Channel>> MakeDaemonChannel(const std::string& address,
                                                         const std::optional<TlsOptions>& tls,
                                                         const ClientToken& token,
                                                         const TlsNames& names,
                                                         grpc::ChannelArguments arguments) {
  if (Status status = ValidateDaemonAddress(address); !status.ok()) return status;
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  const Result<std::string> text = TokenText(token);
  if (!text.ok()) return text.status();
  if (!tls && !text->empty() && !tls::IsLoopback(address)) {
    return Status(StatusCode::kInvalidArgument, "the token would cross the network to " + address +
                                                    " in plain text; connect with TLS (" +
                                                    names.tls + ")");
  }
  if (!tls) return MakeChannel(address, grpc::InsecureChannelCredentials(), arguments, *text);
  if (Status status = ValidateTlsOptions(*tls, names); !status.ok()) return status;
  const auto texts = tls::Read({.cert = tls->cert_file, .key = tls->key_file, .ca = tls->ca_file});
  if (!texts.ok()) {
    return Status(StatusCode::kInvalidArgument, std::string(texts.status().message()));
  }
  if (!tls->server_name.empty()) arguments.SetSslTargetNameOverride(tls->server_name);
  return MakeChannel(address,
                     grpc::SslCredentials({.pem_root_certs = texts->ca,
                                           .pem_private_key = texts->key,
                                           .pem_cert_chain = texts->cert}),
                     arguments, *text);
}

// Recognises the messages of gRPC 1.51 and OpenSSL 3. Returns no advice for other messages.
std::string ConnectionAdvice(const std::string& reason, bool with_tls, const TlsNames& names) {
  if (Has(reason, "certificate verify failed")) {
    return "the daemon's certificate has expired, or is not signed by a known authority: give "
           "the certificate of the authority that signed it (" +
           names.ca + ")";
  }
  if (Has(reason, "is not in peer certificate")) {
    return "the daemon's certificate is for another host: connect to that host, or give its name "
           "(" +
           names.server_name + ")";
  }
  if (Has(reason, "wrong version number")) {
    return "the daemon uses plain text: start it with --tls-cert and --tls-key, or connect "
           "without TLS";
  }
  if (!Has(reason, "failed to connect") || !IsHungUp(reason)) return "";
  if (!with_tls) {
    return "the daemon may require TLS: give the certificate of the authority that signed its own "
           "(" +
           names.ca + ")";
  }
  return "the daemon may require a client certificate: give one that its authority has signed (" +
         names.cert + " and " + names.key +
         "); otherwise its own TLS files may be broken: see its log or /readyz";
}

grpc::Status WithReason(const grpc::Status& status) {
  const auto own = protocol::StatusIn(status.error_details());
  if (!own) return status;
  return {static_cast<grpc::StatusCode>(own->code), own->message + " (" + own->reason + ")",
          status.error_details()};
}

}  // namespace sweepstake
