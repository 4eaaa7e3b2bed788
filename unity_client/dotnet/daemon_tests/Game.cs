using System;
using System.Net.Http;
using Sweepstake.GrpcNet;

namespace Sweepstake.Tests
{
    /// <summary>A small game with a connection.</summary>
    internal sealed class Game : IDisposable
    {
        private const ulong FrameNs = 16_666_667;
        private readonly MotionScene scene;

        internal Game(ITelemetryTransport transport, Action<LinkOptions> change = null, Action<SessionOptions> changeSession = null)
        {
            // This queue does not fill even if the link waits long for a processor or a disk. Without a lane the evidence depends on the
            // frames alone.
            var sessionOptions = new SessionOptions { Arms = "SAP,DBVT,KDTree", QueueFrames = 1 << 16, Shadow = ShadowMode.Off };
            changeSession?.Invoke(sessionOptions);
            Session = new BroadPhaseSession(sessionOptions);
            SceneOptions sceneOptions = SceneOptions.Default;
            sceneOptions.ObjectCount = 100;
            scene = new MotionScene("hurricane", sceneOptions);
            var options = new LinkOptions { Project = "unity", Scene = "hurricane", BatchIntervalMs = 20, BackoffMinMs = 5, BackoffMaxMs = 50 };
            change?.Invoke(options);
            Connection = new DaemonConnection(Session, transport, options);
        }

        internal BroadPhaseSession Session { get; }
        internal DaemonConnection Connection { get; }
        internal ConnectionStatus Status => Connection.Status;
        internal ulong FrameCount { get; private set; }

        internal static Game At(string address, Action<DaemonEndpoint> changeEndpoint = null, Action<LinkOptions> change = null)
        {
            var endpoint = new DaemonEndpoint { Address = address };
            changeEndpoint?.Invoke(endpoint);
            return new Game(new GrpcTelemetryTransport(endpoint), change);
        }

        /// <summary>The handler that a game on .NET uses: with pings and without a proxy.</summary>
        internal static HttpMessageHandler Sockets() => new SocketsHttpHandler
        {
            UseProxy = false,
            KeepAlivePingDelay = TimeSpan.FromSeconds(20),
            KeepAlivePingTimeout = TimeSpan.FromSeconds(10),
        };

        /// <summary>
        /// Selects the policy "paper". At first it samples from posteriors without evidence, so it tries other arms whatever their costs
        /// are.
        /// </summary>
        internal static void ExploresFast(LinkOptions options)
        {
            options.Policy = "paper";
            options.TimeScale = 100;
        }

        internal void Play(int frames)
        {
            for (int frame = 0; frame < frames; ++frame)
            {
                scene.Step();
                Session.BeginFrame();
                Session.FindPairs(scene.Boxes);
                Session.EndFrame(FrameNs);
                ++FrameCount;
            }
        }

        /// <summary>
        /// Plays until the condition is true. Fails only if that takes longer than the generous limit of <see cref="Eventually"/>.
        /// </summary>
        internal void PlayUntil(Func<bool> isSo, string what) =>
            Eventually.Is(isSo, () => $"{what}; {Status.State}, {Status.LastError}, {Connection.Failure}", () => Play(1));

        internal void PlayUntilOnline() => PlayUntil(() => Status.State == LinkState.Online, "online");

        /// <summary>Waits until everything sent is on the daemon's disk.</summary>
        internal void WaitForAcknowledgement()
        {
            PlayUntil(() => Status.Stats.SentSequence > 0, "sending");
            ulong sent = Status.Stats.SentSequence;
            PlayUntil(() => Status.Stats.AcknowledgedSequence >= sent, "acknowledged");
        }

        public void Dispose()
        {
            Session.Dispose();
            scene.Dispose();
        }
    }
}
