#nullable enable
using System;
using System.IO;
using System.Net;
using System.Net.Http;
using Grpc.Core;
using Grpc.Core.Interceptors;
using Grpc.Net.Client;

namespace Sweepstake.GrpcNet
{
    /// <summary>
    /// Where a daemon is and how it is spoken to. The default is the daemon's own default on this machine. Files are read for each connection,
    /// so that they may be replaced while the game runs.
    /// </summary>
    public sealed class DaemonEndpoint
    {
        public const string DefaultAddress = "127.0.0.1:7433";
        private const int MaxMessageBytes = 256 * 1024;
        private const int MaxTokenBytes = 4096;

        /// <summary>HOST:PORT; an IPv6 address in brackets.</summary>
        public string Address { get; set; } = DefaultAddress;

        /// <summary>Null: plain text, which carries no token to another machine.</summary>
        public TlsFiles? Tls { get; set; }

        /// <summary>The token that the daemon may ask for; shown nowhere. Null: none.</summary>
        public string? Token { get; set; }

        /// <summary>A file with the token alone, as `sweepstaked token create --out` writes it. Not with <see cref="Token"/>.</summary>
        public string? TokenFile { get; set; }

        /// <summary>
        /// Makes what speaks HTTP/2, once for each connection, which disposes of it; with one of your own, TLS is its business too, apart from
        /// choosing the scheme. Null: .NET's HttpClientHandler with the TLS files. Unity before 6000.5 has no HTTP/2 and needs one.
        /// </summary>
        public Func<HttpMessageHandler>? Handler { get; set; }

        /// <summary>Whether the address is of this machine.</summary>
        public bool IsLoopback
        {
            get
            {
                string host = AsUri().Host.Trim('[', ']');
                return host == "localhost" || (IPAddress.TryParse(host, out IPAddress? address) && IPAddress.IsLoopback(address));
            }
        }

        internal GrpcChannel OpenChannel()
        {
            var options = new GrpcChannelOptions
            {
                HttpHandler = Handler?.Invoke() ?? MakeHandler(),
                DisposeHttpClient = true,
                MaxReceiveMessageSize = MaxMessageBytes,
                Credentials = Tls == null ? ChannelCredentials.Insecure : ChannelCredentials.SecureSsl,
            };
            return GrpcChannel.ForAddress(AsUri(), options);
        }

        /// <summary>Calls with the token in their headers.</summary>
        /// <exception cref="SweepstakeException">The token is not readable, is no token, or would cross the network in plain text.</exception>
        internal CallInvoker WithToken(GrpcChannel channel)
        {
            string? token = ReadToken();
            if (token == null)
                return channel.CreateCallInvoker();
            if (Tls == null && !IsLoopback)
                throw Wrong($"The token would cross the network to {Address} in plain text; connect with TLS.");
            return channel.CreateCallInvoker().Intercept(headers =>
            {
                headers.Add("authorization", "Bearer " + token);
                return headers;
            });
        }

        private Uri AsUri()
        {
            string scheme = Tls == null ? "http" : "https";
            if (!Uri.TryCreate($"{scheme}://{Address}", UriKind.Absolute, out Uri? uri) || uri.PathAndQuery != "/" || uri.Port <= 0 || uri.UserInfo != "" ||
                Address.LastIndexOf(':') <= Address.LastIndexOf(']'))
            {
                throw Wrong($"'{Address}' is no address of a daemon; write HOST:PORT, as {DefaultAddress}.");
            }
            return uri;
        }

        private HttpMessageHandler MakeHandler()
        {
            var handler = new HttpClientHandler { UseProxy = false, AllowAutoRedirect = false, UseCookies = false };
            Tls?.Configure(handler);
            return handler;
        }

        private string? ReadToken()
        {
            if (!string.IsNullOrEmpty(Token) && !string.IsNullOrEmpty(TokenFile))
                throw Wrong("Give a token or the file of one, not both.");
            string? token = string.IsNullOrEmpty(TokenFile) ? Token : ReadTokenFile(TokenFile!);
            if (string.IsNullOrEmpty(token))
                return null;
            foreach (char c in token!)
            {
                if (c <= ' ' || c > '~' || token.Length > MaxTokenBytes)
                    throw Wrong($"{(string.IsNullOrEmpty(TokenFile) ? "The token given" : TokenFile)} is no token: it is too long, or has characters that none has.");
            }
            return token;
        }

        private static string ReadTokenFile(string path)
        {
            try
            {
                string token = File.ReadAllText(path).TrimEnd();
                return token.Length > 0 ? token : throw Wrong($"{path} holds no token.");
            }
            catch (Exception problem) when (problem is IOException || problem is UnauthorizedAccessException)
            {
                throw Wrong($"Cannot read a token from {path}; name the file that `sweepstaked token create --out` wrote.", problem);
            }
        }

        internal static SweepstakeException Wrong(string problem, Exception? inner = null) =>
            new SweepstakeException(ResultCode.InvalidArgument, problem, inner);
    }
}
