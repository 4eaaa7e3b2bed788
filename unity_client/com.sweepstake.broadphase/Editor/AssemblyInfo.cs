using System.Runtime.CompilerServices;

[assembly: InternalsVisibleTo("Sweepstake.Unity.Tests")]
