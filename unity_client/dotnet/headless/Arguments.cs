using System;
using System.Collections.Generic;
using System.Globalization;

namespace Sweepstake.Headless
{
    /// <summary>The command-line arguments.</summary>
    internal sealed class Arguments
    {
        internal const string Help =
            "Plays a scene in C# and lets a decider choose the broad phase.\n" +
            "\n" +
            "  --daemon HOST:PORT   the daemon that decides; without it this process decides\n" +
            "  --scene NAME         one of the library's scenes, or a .aabbs file (hurricane)\n" +
            "  --objects N          number of objects (3000)\n" +
            "  --seed N             seed of the scene and of the decisions (1)\n" +
            "  --frames N           number of frames (3600)\n" +
            "  --policy NAME        policy of the decider (the decider's default)\n" +
            "  --time-scale X       divides the decider's intervals; a daemon must allow it (1)\n" +
            "  --csv FILE           writes a row for each frame\n" +
            "\n" +
            "Example: dotnet run --project unity_client/dotnet/headless -- --daemon 127.0.0.1:7433 --frames 10000\n" +
            "Exit code: 0 played, 1 no session with the daemon or an incomplete CSV file, 2 bad usage.\n";

        internal string? Daemon;
        internal string Scene = "hurricane";
        internal uint Objects = 3000;
        internal ulong Seed = 1;
        internal int Frames = 3600;
        internal string? Policy;
        internal double TimeScale = 1;
        internal string? Csv;

        /// <exception cref="FormatException">An option is unknown or its value is wrong; the message names it.</exception>
        internal static Arguments Parse(IReadOnlyList<string> words)
        {
            var arguments = new Arguments();
            for (int at = 0; at < words.Count; at += 2)
            {
                if (at + 1 == words.Count)
                    throw new FormatException($"'{words[at]}' needs a value.");
                arguments.Set(words[at], words[at + 1]);
            }
            return arguments;
        }

        private void Set(string option, string value)
        {
            CultureInfo culture = CultureInfo.InvariantCulture;
            try
            {
                switch (option)
                {
                    case "--daemon": Daemon = value; break;
                    case "--scene": Scene = value; break;
                    case "--objects": Objects = uint.Parse(value, culture); break;
                    case "--seed": Seed = ulong.Parse(value, culture); break;
                    case "--frames": Frames = int.Parse(value, culture); break;
                    case "--policy": Policy = value; break;
                    case "--time-scale": TimeScale = double.Parse(value, culture); break;
                    case "--csv": Csv = value; break;
                    default: throw new FormatException($"'{option}' is not an option.");
                }
            }
            catch (Exception wrong) when (wrong is OverflowException || (wrong is FormatException && !wrong.Message.EndsWith("is not an option.", StringComparison.Ordinal)))
            {
                throw new FormatException($"'{value}' is not a valid value of {option}.");
            }
        }
    }
}
