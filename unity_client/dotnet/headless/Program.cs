using System;
using System.IO;
using System.Net.Http;
using Sweepstake.GrpcNet;

namespace Sweepstake.Headless
{
    /// <summary>The loop of a game without a window: move, search, report the cost of the frame. Prints a line each second.</summary>
    internal static class Program
    {
        private const ulong NsPerSecond = 1_000_000_000;
        // Maximum time in milliseconds to complete the CSV file and the connection at the end. It may be long, because no game is running.
        private const int EndTimeoutMs = 60_000;

        private static int Main(string[] words)
        {
            if (Array.IndexOf(words, "--help") >= 0)
            {
                Console.Write(Arguments.Help);
                return 0;
            }
            try
            {
                return Play(Arguments.Parse(words));
            }
            catch (Exception problem) when (problem is FormatException || problem is SweepstakeException || problem is IOException || problem is UnauthorizedAccessException)
            {
                Console.Error.WriteLine(problem.Message + " Use --help to list the options.");
                return 2;
            }
        }

        private static int Play(Arguments arguments)
        {
            SceneOptions sceneOptions = SceneOptions.Default;
            sceneOptions.ObjectCount = arguments.Objects;
            sceneOptions.SpawnSeed = arguments.Seed;
            sceneOptions.MotionSeed = arguments.Seed;
            using var scene = new MotionScene(arguments.Scene, sceneOptions);
            using var session = new BroadPhaseSession(new SessionOptions { Shadow = ShadowMode.Auto });
            using SessionWork decider = Decider(session, arguments);
            using FrameCsvWriter? csv = arguments.Csv == null ? null : new FrameCsvWriter(arguments.Csv, session, arguments.Scene, arguments.Seed);
            PlayFrames(scene, session, decider, csv, arguments.Frames);
            int ended = End(session, decider);
            return csv == null || IsComplete(csv) ? ended : 1;
        }

        private static SessionWork Decider(BroadPhaseSession session, Arguments arguments)
        {
            string name = $"{arguments.Scene}-{arguments.Objects}";
            if (arguments.Daemon == null)
            {
                return new EmbeddedDecider(
                    session, new DeciderOptions { Scene = name, Seed = arguments.Seed, Policy = arguments.Policy, TimeScale = arguments.TimeScale });
            }
            var endpoint = new DaemonEndpoint { Address = arguments.Daemon, Handler = Sockets };
            var options = new LinkOptions
            {
                Daemon = arguments.Daemon, Scene = name, Seed = arguments.Seed, Policy = arguments.Policy, TimeScale = arguments.TimeScale,
            };
            return new DaemonConnection(session, new GrpcTelemetryTransport(endpoint), options);
        }

        private static HttpMessageHandler Sockets() => new SocketsHttpHandler
        {
            UseProxy = false, KeepAlivePingDelay = TimeSpan.FromSeconds(20), KeepAlivePingTimeout = TimeSpan.FromSeconds(10),
        };

        private static void PlayFrames(MotionScene scene, BroadPhaseSession session, SessionWork decider, FrameCsvWriter? csv, int frames)
        {
            ulong beganNs = SteadyClock.NowNs;
            ulong toldNs = beganNs;
            for (int frame = 1; frame <= frames; ++frame)
            {
                scene.Step();
                session.BeginFrame();
                session.FindPairs(scene.Boxes);
                ulong nowNs = SteadyClock.NowNs;
                session.EndFrame(nowNs - beganNs);
                beganNs = nowNs;
                csv?.Write(session.LastSample);
                if (nowNs - toldNs < NsPerSecond && frame < frames)
                    continue;
                toldNs = nowNs;
                Console.WriteLine(Line(frame, session, decider));
            }
        }

        private static string Line(int frame, BroadPhaseSession session, SessionWork decider)
        {
            FrameSample sample = session.LastSample;
            Verdict verdict = session.Verdict;
            string state = decider is DaemonConnection connection ? connection.Status.State.ToString().ToLowerInvariant() : "embedded";
            return FormattableString.Invariant(
                $"frame {frame}: {session.Arms[(int)sample.Arm]}, detection {sample.DetectionTimeNs / 1e6:F3} ms, {sample.PairCount} pairs, ") +
                FormattableString.Invariant($"{session.SwitchEpoch} switches, {verdict.Kind} ({session.Arms[(int)verdict.LeaderArm]}), {state}");
        }

        private static bool IsComplete(FrameCsvWriter csv)
        {
            bool hasEnded = csv.Stop(EndTimeoutMs);
            if (hasEnded && csv.Failure == null && csv.DroppedCount == 0)
                return true;
            string why = csv.Failure != null ? csv.Failure.Message : hasEnded ? $"{csv.DroppedCount} frames were dropped because writing was too slow." : "writing did not end in time, because the disk is too slow.";
            Console.Error.WriteLine("The CSV file is not complete: " + why);
            return false;
        }

        private static int End(BroadPhaseSession session, SessionWork decider)
        {
            if (!(decider is DaemonConnection connection))
                return 0;
            connection.Stop(EndTimeoutMs);
            LinkStats stats = connection.Status.Stats;
            Console.WriteLine(
                $"{stats.SentFrameCount} frames sent, {session.DroppedSampleCount} dropped, {stats.DiscardedFrameCount} refused; " +
                $"{stats.AcknowledgedSequence} of {stats.SentSequence} messages acknowledged; session {connection.Status.SessionId}");
            if (stats.ConnectionCount > 0)
                return 0;
            Console.Error.WriteLine(connection.Status.LastError);
            return 1;
        }
    }
}
