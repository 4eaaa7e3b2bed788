// Serves every gRPC call. gRPC passes a call on as soon as its headers have arrived. The token is
// checked then, before a message is read. Thread-safe.
//
// The table of roles (role_table.h) has a row for each method of sweepstake.v1. A method is one of
// - StreamTelemetry and ImportPriors, which read several messages
// - a Watch method (watch_call.h)
// - a method with one request and a finite answer (served_methods.h)
// grpc.health.v1 needs no token. All other methods are UNIMPLEMENTED.
#pragma once

#include <grpcpp/generic/async_generic_service.h>
#include <grpcpp/grpcpp.h>

#include "server/rpc/health_service.h"
#include "server/rpc/services/priors_service.h"
#include "server/rpc/services/service_context.h"
#include "server/rpc/services/telemetry_service.h"

namespace sweepstake::rpc {

class GenericService final : public grpc::CallbackGenericService {
 public:
  explicit GenericService(ServiceContext& context)
      : context_(context), telemetry_(context), imports_(context) {}

  // Makes the builder's server pass all calls to this object. It must outlive the server.
  void Register(grpc::ServerBuilder& builder);
  grpc::ServerGenericBidiReactor* CreateReactor(grpc::GenericCallbackServerContext* call) override;

  TelemetryService& telemetry() { return telemetry_; }
  HealthService& health() { return health_; }

 private:
  ServiceContext& context_;
  TelemetryService telemetry_;
  PriorImports imports_;
  HealthService health_;
};

}  // namespace sweepstake::rpc
