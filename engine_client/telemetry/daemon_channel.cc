#include "engine_client/telemetry/daemon_channel.h"

#include "engine_client/telemetry/common/validation.h"
#include "server/tls/tls_files.h"

namespace sweepstake {
namespace {

bool Has(const std::string& text, const char* part) { return text.find(part) != text.npos; }

// Whoever is not let in is hung up on. Which words that gets depends on who writes first.
bool IsHungUp(const std::string& reason) {
  return Has(reason, "Socket closed") || Has(reason, "Connection reset by peer") ||
         Has(reason, "Broken pipe");
}

}  // namespace

Result<std::shared_ptr<grpc::Channel>> MakeDaemonChannel(const std::string& address,
                                                         const std::optional<TlsOptions>& tls,
                                                         grpc::ChannelArguments arguments) {
  if (Status status = ValidateDaemonAddress(address); !status.ok()) return status;
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  if (!tls) {
    return grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments);
  }
  if (Status status = ValidateTlsOptions(*tls); !status.ok()) return status;
  const auto texts = tls::Read({.cert = tls->cert_file, .key = tls->key_file, .ca = tls->ca_file});
  if (!texts.ok()) {
    return Status(StatusCode::kInvalidArgument, std::string(texts.status().message()));
  }
  if (!tls->server_name.empty()) arguments.SetSslTargetNameOverride(tls->server_name);
  return grpc::CreateCustomChannel(address,
                                   grpc::SslCredentials({.pem_root_certs = texts->ca,
                                                         .pem_private_key = texts->key,
                                                         .pem_cert_chain = texts->cert}),
                                   arguments);
}

// The words are those of gRPC 1.51 and of OpenSSL 3; with others there is no advice.
std::string ConnectionAdvice(const std::string& reason, bool with_tls) {
  if (Has(reason, "certificate verify failed")) {
    return "the daemon's certificate has expired, or is not signed by a known authority: name the "
           "one that signed it (--tls-ca, ca_file)";
  }
  if (Has(reason, "is not in peer certificate")) {
    return "the daemon's certificate is for another host: connect to that one, or say its name "
           "(--tls-server-name, server_name)";
  }
  if (Has(reason, "wrong version number")) {
    return "the daemon speaks plain text: start it with --tls-cert and --tls-key, or connect "
           "without TLS";
  }
  if (!Has(reason, "failed to connect") || !IsHungUp(reason)) return "";
  return with_tls ? "the daemon may ask for a certificate of yours: name one that its authority "
                    "signed (--tls-cert and --tls-key, cert_file and key_file)"
                  : "the daemon may speak TLS only: name the authority that signed its certificate "
                    "(--tls-ca, ca_file)";
}

}  // namespace sweepstake
