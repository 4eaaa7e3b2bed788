using System;
using System.Collections.Generic;
using System.IO;
using System.Net;
using System.Net.Sockets;
using System.Threading.Tasks;
using Sweepstake.Protocol.V1;

namespace Sweepstake.Tests
{
    /// <summary>
    /// A proxy between a client and a daemon that use HTTP/2 in plain text: forwards everything and records the client's messages. It delays
    /// the goodbye, so that the daemon makes a decision after the last frame.
    /// </summary>
    internal sealed class Http2Tap : IDisposable
    {
        private const int PrefaceBytes = 24;
        private const int FrameHeaderBytes = 9;
        private const int MessageHeaderBytes = 5;
        private const byte DataFrame = 0;

        private readonly TcpListener listener = new TcpListener(IPAddress.Loopback, 0);
        private readonly string daemon;
        private readonly TimeSpan goodbyeDelay;
        private readonly List<byte> due = new List<byte>();

        internal Http2Tap(string daemon, TimeSpan goodbyeDelay)
        {
            this.daemon = daemon;
            this.goodbyeDelay = goodbyeDelay;
            listener.Start();
            Passing = PassOn();
        }

        internal string Address => $"127.0.0.1:{((IPEndPoint)listener.LocalEndpoint).Port}";
        /// <summary>Completes when the client's connection has ended.</summary>
        internal Task Passing { get; }
        /// <summary>The bytes of each message without its header.</summary>
        internal List<byte[]> Messages { get; } = new List<byte[]>();

        public void Dispose() => listener.Stop();

        private async Task PassOn()
        {
            using TcpClient client = await listener.AcceptTcpClientAsync();
            using var server = new TcpClient();
            await server.ConnectAsync(IPEndPoint.Parse(daemon));
            Task back = server.GetStream().CopyToAsync(client.GetStream());
            try
            {
                await PassFrames(client.GetStream(), server.GetStream());
            }
            catch (Exception ended) when (ended is IOException || ended is ObjectDisposedException)
            {
                // Ignored, because clients may end their connection in different ways.
            }
            server.Close();
            await Task.WhenAny(back);
        }

        private async Task PassFrames(NetworkStream from, NetworkStream to)
        {
            await to.WriteAsync(await Read(from, PrefaceBytes));
            while (true)
            {
                byte[] header = await Read(from, FrameHeaderBytes);
                byte[] payload = await Read(from, header[0] << 16 | header[1] << 8 | header[2]);
                if (header[3] == DataFrame && Take(payload))
                    await Task.Delay(goodbyeDelay);
                await to.WriteAsync(header);
                await to.WriteAsync(payload);
            }
        }

        /// <summary>Records the messages that this payload completes; returns whether one of them is a goodbye.</summary>
        private bool Take(byte[] payload)
        {
            bool isGoodbye = false;
            due.AddRange(payload);
            while (due.Count >= MessageHeaderBytes)
            {
                int size = due[1] << 24 | due[2] << 16 | due[3] << 8 | due[4];
                if (due.Count < MessageHeaderBytes + size)
                    break;
                byte[] message = due.GetRange(MessageHeaderBytes, size).ToArray();
                due.RemoveRange(0, MessageHeaderBytes + size);
                Messages.Add(message);
                isGoodbye |= StreamTelemetryRequest.Parser.ParseFrom(message).Goodbye != null;
            }
            return isGoodbye;
        }

        private static async Task<byte[]> Read(NetworkStream from, int count)
        {
            var bytes = new byte[count];
            await from.ReadExactlyAsync(bytes);
            return bytes;
        }
    }
}
