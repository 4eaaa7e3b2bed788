#nullable enable
using System;
using Grpc.Core;
using Grpc.Net.Client;
using Sweepstake.Protocol.V1;

namespace Sweepstake.GrpcNet
{
    /// <summary>
    /// The daemon's services for tools, through the generated stubs: live posteriors, and export and import of evidence. Thread-safe. The
    /// only data that leaves the machine is the requests to the daemon.
    /// </summary>
    public sealed class DaemonClient : IDisposable
    {
        private readonly GrpcChannel channel;

        /// <exception cref="SweepstakeException">The endpoint is invalid; the message says why.</exception>
        public DaemonClient(DaemonEndpoint endpoint)
        {
            channel = (endpoint ?? throw new ArgumentNullException(nameof(endpoint))).OpenChannel();
            try
            {
                CallInvoker calls = endpoint.WithToken(channel);
                Posteriors = new PosteriorsService.PosteriorsServiceClient(calls);
                Priors = new PriorsService.PriorsServiceClient(calls);
            }
            catch
            {
                channel.Dispose();
                throw;
            }
        }

        public PosteriorsService.PosteriorsServiceClient Posteriors { get; }
        public PriorsService.PriorsServiceClient Priors { get; }

        public void Dispose()
        {
            channel.Dispose();
        }
    }
}
