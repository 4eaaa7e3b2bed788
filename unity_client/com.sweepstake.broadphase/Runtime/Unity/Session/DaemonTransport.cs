#nullable enable
#if SWEEPSTAKE_GRPC && (UNITY_EDITOR || !UNITY_WEBGL)
#define HAS_GRPC
#endif
#if HAS_GRPC
using System;
using System.IO;
using System.Net.Http;
using Sweepstake.GrpcNet;
using UnityEngine;
#endif

namespace Sweepstake.Unity
{
    /// <summary>Makes the way to a daemon from a config; without gRPC's libraries it says what is missing.</summary>
    public static class DaemonTransport
    {
        /// <exception cref="SweepstakeException">There is no gRPC here, or a setting is wrong; the message says what to do.</exception>
        public static ITelemetryTransport Make(DaemonSettings settings)
        {
#if HAS_GRPC
            return new GrpcTelemetryTransport(EndpointOf(settings));
#elif UNITY_WEBGL
            throw new SweepstakeException(ResultCode.FailedPrecondition, "A browser cannot speak to a daemon. Leave 'Is Used' of the config's daemon off.");
#else
            throw new SweepstakeException(
                ResultCode.FailedPrecondition,
                "The game has no gRPC, so it cannot speak to a daemon. Window > Sweepstake > Setup says what is missing.");
#endif
        }

#if HAS_GRPC
        /// <summary>Where the daemon of a config is and how it is spoken to, with the handler that this Unity needs.</summary>
        /// <exception cref="SweepstakeException">A setting cannot work here; the message says what to do.</exception>
        public static DaemonEndpoint EndpointOf(DaemonSettings settings)
        {
            TlsFiles? tls = !settings.usesTls ? null : new TlsFiles
            {
                CaFile = FileOf(settings.caFile), CertFile = FileOf(settings.certFile), KeyFile = FileOf(settings.keyFile),
            };
            return new DaemonEndpoint
            {
                Address = settings.address, Tls = tls, TokenFile = FileOf(settings.tokenFile), Handler = HandlerFor(tls),
            };
        }

        private static string? FileOf(string path)
        {
            if (path.Length == 0 || Path.IsPathRooted(path))
                return path.Length == 0 ? null : path;
            // Android's are in the application's archive, of which this is an address.
            if (Application.streamingAssetsPath.Contains("://"))
            {
                throw new SweepstakeException(
                    ResultCode.FailedPrecondition,
                    $"'{path}' cannot be read: StreamingAssets are no files here. Write it below Application.persistentDataPath and give the config its whole path.");
            }
            return Path.Combine(Application.streamingAssetsPath, path);
        }

#if SWEEPSTAKE_YET_ANOTHER_HTTP_HANDLER
        private static Func<HttpMessageHandler>? HandlerFor(TlsFiles? tls) => () => new Cysharp.Net.Http.YetAnotherHttpHandler
        {
            Http2Only = true,
            RootCertificates = TextOf(tls?.CaFile),
            ClientAuthCertificates = TextOf(tls?.CertFile),
            ClientAuthKey = TextOf(tls?.KeyFile),
            Http2KeepAliveInterval = TimeSpan.FromSeconds(20),
        };

        private static string? TextOf(string? path) => path == null ? null : File.ReadAllText(path);
#elif UNITY_6000_5_OR_NEWER
        private static Func<HttpMessageHandler>? HandlerFor(TlsFiles? tls)
        {
            if (tls?.CaFile != null || tls?.CertFile != null)
            {
                throw new SweepstakeException(
                    ResultCode.FailedPrecondition,
                    "Unity's own HTTP handler takes no authority and no certificate. Install YetAnotherHttpHandler; Window > Sweepstake > Setup says how.");
            }
            return () => new UnityEngine.Networking.UnityHttpMessageHandler { HttpForcedVersion = UnityEngine.Networking.HttpForcedVersion.HTTP2 };
        }
#elif UNITY_5_3_OR_NEWER
        private static Func<HttpMessageHandler>? HandlerFor(TlsFiles? tls) => throw new SweepstakeException(
            ResultCode.FailedPrecondition,
            "This Unity has no HTTP/2, so the game cannot speak to a daemon. Install YetAnotherHttpHandler; Window > Sweepstake > Setup says how.");
#else
        private static Func<HttpMessageHandler>? HandlerFor(TlsFiles? tls) => null;
#endif
#endif
    }
}
