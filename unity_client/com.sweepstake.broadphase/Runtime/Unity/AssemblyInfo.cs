using System.Runtime.CompilerServices;

[assembly: InternalsVisibleTo("Sweepstake.Editor")]
[assembly: InternalsVisibleTo("Sweepstake.Unity.Tests")]
