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
    /// <summary>Creates the transport to a daemon from a config; without gRPC's libraries the exception says what is missing.</summary>
    public static class DaemonTransport
    {
        /// <exception cref="SweepstakeException">gRPC is missing, or a setting is wrong; the message says what to do.</exception>
        public static ITelemetryTransport Make(DaemonSettings settings)
        {
#if HAS_GRPC
            return new GrpcTelemetryTransport(EndpointOf(settings));
#elif UNITY_WEBGL
            throw new SweepstakeException(ResultCode.FailedPrecondition, "A game in a browser cannot connect to a daemon. Switch off 'Is Used' of the config's daemon.");
#else
            throw new SweepstakeException(
                ResultCode.FailedPrecondition,
                "The game does not contain gRPC, so it cannot connect to a daemon. Window > Sweepstake > Setup shows what is missing.");
#endif
        }

#if HAS_GRPC
        /// <summary>The endpoint of a config's daemon, with the HTTP handler that this Unity version needs.</summary>
        /// <exception cref="SweepstakeException">A setting does not work on this platform; the message says what to do.</exception>
        public static DaemonEndpoint EndpointOf(DaemonSettings settings) => new DaemonEndpoint
        {
            Address = settings.address, UsesTls = settings.usesTls, TokenFile = FileOf(settings.tokenFile), Handler = HandlerFor(settings),
        };

        private static string? FileOf(string path)
        {
            if (path.Length == 0 || Path.IsPathRooted(path))
                return path.Length == 0 ? null : path;
            // On Android, StreamingAssets are entries of the application's archive, and the path is a URL.
            if (Application.streamingAssetsPath.Contains("://"))
            {
                throw new SweepstakeException(
                    ResultCode.FailedPrecondition,
                    $"'{path}' cannot be read: on this platform StreamingAssets are not files. Copy it to a folder below Application.persistentDataPath, and set its absolute path in the config.");
            }
            return Path.Combine(Application.streamingAssetsPath, path);
        }

        /// <summary>The files of TLS; null without TLS or without such a file.</summary>
        internal static (string? Authorities, string? Certificate, string? Key) TlsFilesOf(DaemonSettings settings) =>
            settings.usesTls ? (FileOf(settings.caFile), FileOf(settings.certFile), FileOf(settings.keyFile)) : default;

#if SWEEPSTAKE_YET_ANOTHER_HTTP_HANDLER
        private static Func<HttpMessageHandler>? HandlerFor(DaemonSettings settings)
        {
            (string? authorities, string? certificate, string? key) = TlsFilesOf(settings);
            return () => new Cysharp.Net.Http.YetAnotherHttpHandler
            {
                Http2Only = true,
                RootCertificates = TextOf(authorities),
                ClientAuthCertificates = TextOf(certificate),
                ClientAuthKey = TextOf(key),
                Http2KeepAliveInterval = TimeSpan.FromSeconds(20),
            };
        }

        private static string? TextOf(string? path) => path == null ? null : File.ReadAllText(path);
#elif UNITY_6000_5_OR_NEWER
        private static Func<HttpMessageHandler>? HandlerFor(DaemonSettings settings)
        {
            if (settings.usesTls && (settings.caFile.Length > 0 || settings.certFile.Length > 0))
            {
                throw new SweepstakeException(
                    ResultCode.FailedPrecondition,
                    "Unity's own HTTP handler does not support an authority or a certificate. Install YetAnotherHttpHandler; Window > Sweepstake > Setup shows how.");
            }
            return () => new UnityEngine.Networking.UnityHttpMessageHandler { HttpForcedVersion = UnityEngine.Networking.HttpForcedVersion.HTTP2 };
        }
#elif UNITY_5_3_OR_NEWER
        private static Func<HttpMessageHandler>? HandlerFor(DaemonSettings settings) => throw new SweepstakeException(
            ResultCode.FailedPrecondition,
            "This Unity version does not have HTTP/2, so the game cannot connect to a daemon. Install YetAnotherHttpHandler; Window > Sweepstake > Setup shows how.");
#else
        private static Func<HttpMessageHandler>? HandlerFor(DaemonSettings settings) => null;
#endif
#endif
    }
}
