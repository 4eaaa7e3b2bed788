#nullable enable
using System;
using Grpc.Core;
using Grpc.Net.Client;
using Sweepstake.Protocol.V1;

namespace Sweepstake.GrpcNet
{
    /// <summary>
    /// The daemon's services for tools, through the generated stubs: what it believes, live, and evidence in and out. Thread-safe. What it
    /// sends to the daemon are the requests alone.
    /// </summary>
    public sealed class DaemonClient : IDisposable
    {
        private readonly GrpcChannel channel;

        /// <exception cref="SweepstakeException">The endpoint is not right; the message says why.</exception>
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
