#if UNITY_6000_5_OR_NEWER
using System.Net.Http;
using System.Threading;
using System.Threading.Tasks;

namespace UnityEngine.Networking
{
    public enum HttpForcedVersion
    {
        NotForced = 0,
        HTTP2 = 3,
    }

    public sealed class UnityHttpMessageHandler : HttpMessageHandler
    {
        public HttpForcedVersion HttpForcedVersion { get; set; }

        protected override Task<HttpResponseMessage> SendAsync(HttpRequestMessage httpRequest, CancellationToken cancellationToken) =>
            Task.FromException<HttpResponseMessage>(new HttpRequestException("This stub has no network."));
    }
}
#endif
