#nullable enable
using System;

namespace Sweepstake
{
    /// <summary>The result of a native call.</summary>
    public enum ResultCode
    {
        Ok = 0,
        /// <summary>An argument is wrong.</summary>
        InvalidArgument = 1,
        /// <summary>The file, name or proxy does not exist.</summary>
        NotFound = 2,
        /// <summary>A file exists, but its content is broken.</summary>
        DataLoss = 3,
        /// <summary>Something could not be reached; trying again may help.</summary>
        Unavailable = 4,
        /// <summary>A buffer is too small, a limit was reached, or memory is exhausted.</summary>
        ResourceExhausted = 5,
        /// <summary>Functions were called in the wrong order.</summary>
        FailedPrecondition = 6,
        /// <summary>A bug of the library.</summary>
        Internal = 7,
    }

    /// <summary>An operation failed; the message gives the reason.</summary>
    public class SweepstakeException : Exception
    {
        public SweepstakeException(ResultCode code, string message, Exception? inner = null)
            : base(message, inner)
        {
            Code = code;
        }

        public ResultCode Code { get; }
    }

    /// <summary>The native library is missing, has another ABI, or was built for another platform.</summary>
    public sealed class NativeLibraryException : SweepstakeException
    {
        public NativeLibraryException(string problem, string remedy, Exception? inner = null)
            : base(ResultCode.Unavailable, problem + " " + remedy, inner)
        {
            Problem = problem;
            Remedy = remedy;
        }

        /// <summary>What is wrong, as a sentence.</summary>
        public string Problem { get; }
        /// <summary>What to do, as a sentence.</summary>
        public string Remedy { get; }
    }
}
