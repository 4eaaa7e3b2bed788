#nullable enable
using System;
using System.IO;
using System.Linq;
using System.Net.Http;
using Grpc.Core;
using Grpc.Core.Interceptors;
using Grpc.Net.Client;

namespace Sweepstake.GrpcNet
{
    /// <summary>
    /// Address and credentials of a daemon. The default is the default address of a daemon on this machine. The token's file is read again for
    /// each connection, so it may be replaced while the game runs.
    /// </summary>
    public sealed class DaemonEndpoint
    {
        public const string DefaultAddress = "127.0.0.1:7433";
        private const int MaxMessageBytes = 256 * 1024;
        private const int MaxTokenBytes = 4096;

        /// <summary>HOST:PORT; an IPv6 address in brackets.</summary>
        public string Address { get; set; } = DefaultAddress;
        /// <summary>Whether to use TLS, which <see cref="Handler"/> configures. Without TLS no token is sent to another machine.</summary>
        public bool UsesTls { get; set; }
        /// <summary>The token for a daemon that requires one; never displayed. Null for none.</summary>
        public string? Token { get; set; }
        /// <summary>
        /// A file that contains only the token, as written by `sweepstaked token create --out`. Do not set <see cref="Token"/> too.
        /// </summary>
        public string? TokenFile { get; set; }
        /// <summary>
        /// Creates the HTTP/2 handler. It is called once for each connection, and the connection disposes of the handler. The handler has the
        /// certificate authorities and the game's certificate. If null, .NET's HttpClientHandler with the system's authorities is used. Unity
        /// before 6000.5 does not have HTTP/2 and needs a custom handler.
        /// </summary>
        public Func<HttpMessageHandler>? Handler { get; set; }
        /// <summary>Whether the address belongs to this machine.</summary>
        public bool IsLoopback => AsUri().IsLoopback;

        /// <param name="calls">Its calls have the token in their headers.</param>
        internal GrpcChannel OpenChannel(out CallInvoker calls)
        {
            Uri uri = AsUri();
            string? token = ReadToken();
            if (token != null && !UsesTls && !IsLoopback)
                throw Wrong($"The token would be sent to {Address} in plain text; connect with TLS.");
            GrpcChannel channel = GrpcChannel.ForAddress(uri, new GrpcChannelOptions
            {
                HttpHandler = Handler?.Invoke() ?? new HttpClientHandler { UseProxy = false, AllowAutoRedirect = false, UseCookies = false },
                DisposeHttpClient = true,
                MaxReceiveMessageSize = MaxMessageBytes,
                Credentials = UsesTls ? ChannelCredentials.SecureSsl : ChannelCredentials.Insecure,
            });
            calls = channel.CreateCallInvoker().Intercept(headers =>
            {
                if (token != null)
                    headers.Add("authorization", "Bearer " + token);
                return headers;
            });
            return channel;
        }

        private Uri AsUri()
        {
            string scheme = UsesTls ? "https" : "http";
            if (!Uri.TryCreate($"{scheme}://{Address}", UriKind.Absolute, out Uri? uri) || uri.PathAndQuery != "/" || uri.Port <= 0 || uri.UserInfo != "" ||
                Address.LastIndexOf(':') <= Address.LastIndexOf(']'))
            {
                throw Wrong($"'{Address}' is not the address of a daemon; write HOST:PORT, for example {DefaultAddress}.");
            }
            return uri;
        }

        private string? ReadToken()
        {
            if (!string.IsNullOrEmpty(Token) && !string.IsNullOrEmpty(TokenFile))
                throw Wrong("Give a token or a token file, not both.");
            string? token = string.IsNullOrEmpty(TokenFile) ? Token : ReadTokenFile(TokenFile!);
            if (string.IsNullOrEmpty(token))
                return null;
            return token!.Length <= MaxTokenBytes && token.All(c => c > ' ' && c <= '~') ? token : throw Wrong(
                $"{(string.IsNullOrEmpty(TokenFile) ? "The token given" : TokenFile)} is not a token: it is too long or has invalid characters.");
        }

        private static string ReadTokenFile(string path)
        {
            try
            {
                string token = File.ReadAllText(path).TrimEnd();
                return token.Length > 0 ? token : throw Wrong($"{path} does not contain a token.");
            }
            catch (Exception problem) when (problem is IOException || problem is UnauthorizedAccessException)
            {
                throw Wrong($"Cannot read a token from {path}; name a file that `sweepstaked token create --out` wrote.", problem);
            }
        }

        private static SweepstakeException Wrong(string problem, Exception? inner = null) =>
            new SweepstakeException(ResultCode.InvalidArgument, problem, inner);
    }
}
