using System;
using System.Net.Http;
using System.Security.Cryptography.X509Certificates;
using Sweepstake.GrpcNet;

namespace Sweepstake.Tests
{
    /// <summary>TLS with files in PEM format, as a game on .NET configures it in its handler.</summary>
    internal static class PrivateTls
    {
        /// <summary>Returns the change of an endpoint that trusts only these authorities.</summary>
        /// <param name="certFile">The game's certificate; null for none.</param>
        internal static Action<DaemonEndpoint> With(string caFile, string certFile = null, string keyFile = null) => endpoint =>
        {
            endpoint.UsesTls = true;
            endpoint.Handler = () => HandlerFor(caFile, certFile, keyFile);
        };

        private static HttpMessageHandler HandlerFor(string caFile, string certFile, string keyFile)
        {
            var policy = new X509ChainPolicy { TrustMode = X509ChainTrustMode.CustomRootTrust, RevocationMode = X509RevocationMode.NoCheck };
            policy.CustomTrustStore.ImportFromPemFile(caFile);
            var handler = new SocketsHttpHandler { UseProxy = false };
            handler.SslOptions.CertificateChainPolicy = policy;
            if (certFile != null)
                handler.SslOptions.ClientCertificates = new X509CertificateCollection { X509Certificate2.CreateFromPemFile(certFile, keyFile) };
            return handler;
        }
    }
}
