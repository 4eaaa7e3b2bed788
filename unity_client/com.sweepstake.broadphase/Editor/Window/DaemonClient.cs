#if SWEEPSTAKE_GRPC
#nullable enable
using System;
using Grpc.Core;
using Grpc.Net.Client;
using Sweepstake.GrpcNet;
using Sweepstake.Protocol.V1;

namespace Sweepstake.Editor
{
    /// <summary>The daemon's services for tools of the editor, through the generated stubs. Thread-safe. Only requests leave the machine.</summary>
    public sealed class DaemonClient : IDisposable
    {
        private readonly GrpcChannel channel;

        /// <exception cref="SweepstakeException">The endpoint is invalid; the message says why.</exception>
        public DaemonClient(DaemonEndpoint endpoint)
        {
            channel = (endpoint ?? throw new ArgumentNullException(nameof(endpoint))).OpenChannel(out CallInvoker calls);
            Posteriors = new PosteriorsService.PosteriorsServiceClient(calls);
            Priors = new PriorsService.PriorsServiceClient(calls);
            Sessions = new SessionsService.SessionsServiceClient(calls);
        }

        public PosteriorsService.PosteriorsServiceClient Posteriors { get; }
        public PriorsService.PriorsServiceClient Priors { get; }
        public SessionsService.SessionsServiceClient Sessions { get; }

        public void Dispose() => channel.Dispose();
    }
}
#endif
