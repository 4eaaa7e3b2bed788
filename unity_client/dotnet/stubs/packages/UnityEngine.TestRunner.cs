using System;
using System.Collections;
using NUnit.Framework;
using NUnit.Framework.Interfaces;
using NUnit.Framework.Internal;
using NUnit.Framework.Internal.Builders;

namespace UnityEngine.TestTools
{
    /// <summary>In this stub a test runs at once, with one frame of the player at each yield.</summary>
    [AttributeUsage(AttributeTargets.Method)]
    public class UnityTestAttribute : NUnitAttribute, ISimpleTestBuilder, IImplyFixture
    {
        TestMethod ISimpleTestBuilder.BuildFrom(IMethodInfo method, Test suite) =>
            new NUnitTestCaseBuilder().BuildTestMethod(new PlayedMethod(method), suite, null);

        /// <summary>A test method without a result, which plays the frames of one that returns an IEnumerator.</summary>
        private sealed class PlayedMethod : MethodWrapper, IMethodInfo
        {
            internal PlayedMethod(IMethodInfo method)
                : base(method.TypeInfo.Type, method.MethodInfo)
            {
            }

            ITypeInfo IMethodInfo.ReturnType => new TypeWrapper(typeof(void));

            object IMethodInfo.Invoke(object fixture, params object[] args)
            {
                var steps = (IEnumerator)Invoke(fixture, args);
                while (steps.MoveNext())
                    Player.Frame();
                return null;
            }
        }
    }
}
